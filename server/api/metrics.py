"""The service's figures for Prometheus, read when they are asked for."""

from collections.abc import Iterator

from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric, SummaryMetricFamily
from prometheus_client.registry import Collector

from server.services.container import Services


class ServiceCollector(Collector):
    """Reads link, lease, viewers and events of all rigs.

    Args:
        services: where the figures are.
    """

    def __init__(self, services: Services) -> None:
        self._services = services

    def collect(self) -> Iterator[Metric]:
        """Give all metrics."""
        yield from self._rigs()
        yield from self._links()
        yield from self._jobs()
        yield from self._analyses()
        events = self._services.events
        yield CounterMetricFamily(
            "jointscope_events_dropped", "Events that could not be stored.", events.dropped
        )
        yield GaugeMetricFamily("jointscope_event_viewers", "Open event streams.", events.stored.subscribers)
        yield GaugeMetricFamily(
            "jointscope_session_followers",
            "Who follows a session live.",
            self._services.sessions.news.followers,
        )
        yield from self._counted()

    def _counted(self) -> Iterator[Metric]:
        figures = self._services.figures
        for name, words, counter in (
            ("live_frames", "Frames of live data sent.", figures.frames_sent),
            (
                "live_samples_dropped",
                "Samples dropped for viewers that read too slowly.",
                figures.samples_dropped,
            ),
            ("live_viewers_given_up", "Viewers cut off because they took nothing.", figures.viewers_given_up),
            ("tokens_refused", "Wrong tokens and tickets.", figures.tokens_refused),
        ):
            yield CounterMetricFamily(f"jointscope_{name}", words, counter.value)

    def _analyses(self) -> Iterator[Metric]:
        analyses = self._services.analyses
        took = analyses.ledger.took
        yield GaugeMetricFamily("jointscope_analyses_running", "Analyses that run.", analyses.running)
        yield GaugeMetricFamily("jointscope_analyses_waiting", "Analyses that wait.", analyses.queued)
        yield SummaryMetricFamily(
            "jointscope_analysis_seconds", "Time of analyses.", count_value=took.count, sum_value=took.total_s
        )
        yield GaugeMetricFamily("jointscope_analysis_longest_seconds", "Longest analysis.", took.longest_s)

    def _rigs(self) -> Iterator[Metric]:
        connected = GaugeMetricFamily("jointscope_rig_connected", "1 while connected.", labels=["rig"])
        armed = GaugeMetricFamily("jointscope_rig_armed", "1 while the drive is on.", labels=["rig"])
        lease = GaugeMetricFamily(
            "jointscope_lease_left_seconds", "What is left of the operator's lease.", labels=["rig"]
        )
        viewers = GaugeMetricFamily("jointscope_viewers", "Who watches the samples.", labels=["rig"])
        for rig in self._services.rigs.all():
            view = rig.view()
            connected.add_metric([rig.id], float(view.connection == "connected"))
            armed.add_metric([rig.id], float(view.armed))
            lease.add_metric([rig.id], view.lease.expires_in_s if view.lease else 0.0)
            viewers.add_metric([rig.id], view.viewers)
        yield from (connected, armed, lease, viewers)

    def _jobs(self) -> Iterator[Metric]:
        queue = GaugeMetricFamily(
            "jointscope_queue_length", "Campaigns that wait for the rig.", labels=["rig"]
        )
        last = GaugeMetricFamily(
            "jointscope_fit_seconds", "Time that the live estimators took for the last rows.", labels=["rig"]
        )
        worst = GaugeMetricFamily(
            "jointscope_fit_seconds_max", "Longest such time of the session that runs.", labels=["rig"]
        )
        for rig in self._services.rigs.all():
            queue.add_metric([rig.id], self._services.campaigns.queue_length(rig.id))
            live = self._services.sessions.live_of(rig.id)
            last.add_metric([rig.id], 0.0 if live is None else live.fit_time_s)
            worst.add_metric([rig.id], 0.0 if live is None else live.fit_time_max_s)
        yield from (queue, last, worst)

    def _links(self) -> Iterator[Metric]:
        families: dict[str, CounterMetricFamily] = {}
        for rig in self._services.rigs.all():
            for name, value in rig.link_figures().items():
                family = families.setdefault(
                    name,
                    CounterMetricFamily(
                        f"jointscope_link_{name}", f"Link: {name.replace('_', ' ')}.", labels=["rig"]
                    ),
                )
                family.add_metric([rig.id], value)
        yield from families.values()
