"""The pytest plugin as other projects use it: in a temporary project of their own."""

import os
from pathlib import Path

import pytest

from jointscope_client.emulated_service import FILES

CONFIG = Path(__file__).resolve().parents[2] / "config"


@pytest.mark.slow
def test_another_project_tests_against_the_emulated_controller(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        def test_my_code(emulated_rig):
            with emulated_rig.lease() as lease:
                assert lease.write_parameter("current_limit_A", 1.0).value == 1.0


        def test_a_rig_comes_back_to_rest(emulated_rig):
            emulated_rig.client.rigs.estop(emulated_rig.id)


        def test_it_is_at_rest_again(emulated_rig):
            assert emulated_rig.state().raw["lease"] is None
            assert not emulated_rig.state().raw["drive"]["faults"]
        """
    )
    result = pytester.runpytest_subprocess("-q", "--strict-markers", "-W", "error")
    result.assert_outcomes(passed=3)


@pytest.mark.slow
def test_the_mark_chooses_the_scenario(pytester: pytest.Pytester) -> None:
    scenario = CONFIG / "scenarios" / "hidden_friction.yaml"
    pytester.makepyfile(
        f"""
        import stat, os, pytest

        @pytest.mark.emulated_rig(scenario={str(scenario)!r}, speed="1")
        def test_a_controller_alone(emulated_port):
            assert stat.S_ISCHR(os.stat(emulated_port).st_mode)

        @pytest.mark.emulated_rig(scenario="absent.yaml")
        def test_a_scenario_that_is_not_there(emulated_port):
            pass
        """
    )
    result = pytester.runpytest_subprocess("-q", "--strict-markers", "-W", "error")
    result.assert_outcomes(passed=1, errors=1)
    result.stdout.fnmatch_lines(["*absent.yaml*"])


def test_the_plugins_rig_is_the_projects_own() -> None:
    for path in ("rigs/emulated.yaml", "scenarios/nominal.yaml"):
        assert (FILES / path).read_bytes() == (CONFIG / path).read_bytes()


def test_the_plugin_costs_nothing_where_it_is_not_used(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        import sys

        def test_nothing_is_imported():
            assert "jointscope_client.emulated_service" not in sys.modules
            assert "httpx" not in sys.modules
        """
    )
    os.environ.pop("PYTEST_ADDOPTS", None)
    pytester.runpytest_subprocess("-q").assert_outcomes(passed=1)
