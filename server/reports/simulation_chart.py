"""The picture of a simulation: each output simulated and measured, above the input."""

from server.reports.charts import Chart, Panel, Role, Trace
from server.services.simulation import Simulation


def simulation_chart(simulation: Simulation, key: str) -> Chart:
    """Return the chart; `key` names its PNG file."""
    record = simulation.record
    panels = []
    for name, values in record.simulated.items():
        traces = [Trace(name="simulated", x=record.time_s, y=values)]
        if name in record.measured:
            traces.insert(
                0, Trace(name="measured", x=record.time_s, y=record.measured[name], role=Role.MEASURED)
            )
        panels.append(Panel(title=name, y_label=f"{name} [{simulation.units[name]}]", traces=tuple(traces)))
    unit = simulation.units[simulation.input]
    drive = Trace(name=simulation.input, x=record.time_s, y=record.input, number=1)
    panels.append(Panel(title=simulation.input, y_label=f"{simulation.input} [{unit}]", traces=(drive,)))
    return Chart(
        key=key, title=f"{simulation.model_name} in free run", x_label="time [s]", panels=tuple(panels)
    )
