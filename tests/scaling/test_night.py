"""What docs/scaling.md computes from measured costs."""

import pytest

from benchmarks import scaling
from benchmarks.scaling import Cost, CountingExecutor, report


def test_a_night_is_computed_from_the_mean_cost() -> None:
    sizes = {"memory_bytes": 400_000_000, "input_bytes": 5_000_000, "answer_bytes": 1_000_000}
    costs = [Cost(hidden="a", verdict="named", cpu_s=cpu, **sizes) for cpu in (20.0, 41.2)]
    traffic = CountingExecutor()
    assert list(traffic.map(abs, [-1, -2])) == [1, 2]
    text = report(costs, traffic)
    # 10,000 x 30.6 s = 85 core hours, in 10 h at 85 %: 10 cores, with 0.4 GB each; 50 GB out and 10 GB back.
    assert "30.6 s a joint, 85 core hours" in text
    assert "| cores, 85% busy | **10** |" in text
    assert "400 MB a process, 4 GB in all" in text
    assert "50 GB out, 10 GB back, 13.3 Mbit/s" in text
    assert "2 tasks" in text


def test_shared_functions_count_once() -> None:
    traffic = CountingExecutor()
    list(traffic.map(abs, [-1, -2, -3]))
    assert traffic.shipped_bytes == sum(traffic.shared.values()) + traffic.item_bytes
    assert len(traffic.shared) == 1
    assert traffic.unshared_bytes > traffic.shipped_bytes


def test_the_page_has_the_place_for_the_tables() -> None:
    page = scaling.PAGE.read_text(encoding="utf-8")
    assert page.index(scaling.BEGIN) < page.index(scaling.END)


def test_a_task_that_fails_is_not_hidden() -> None:
    with pytest.raises(TypeError):
        CountingExecutor().submit(abs, "text")
