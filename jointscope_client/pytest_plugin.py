"""A pytest plugin: code that uses a rig is tested against the emulated controller. See docs/testing_your_code.md.

    def test_my_code(emulated_rig):
        with emulated_rig.lease() as lease:
            my_code(emulated_rig.client, lease)

It is loaded by every pytest run where Jointscope is installed, so it imports nothing of ours before a fixture is used.
"""

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from jointscope_client.emulated_service import EmulatedRig

MARK = "emulated_rig"
_HELP = "emulated_rig(scenario=PATH, speed='max'): what the emulated controller of the fixtures is like"


def pytest_configure(config: pytest.Config) -> None:
    """Make the mark known."""
    config.addinivalue_line("markers", _HELP)


@pytest.fixture(scope="session")
def emulated_rigs(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[..., "EmulatedRig"]]:
    """Return a function (scenario, speed) that gives an emulated rig; each kind is started once."""
    from jointscope_client.emulated_service import NOMINAL, EmulatedRig, emulated_service

    running: dict[tuple[Path, str], EmulatedRig] = {}
    with contextlib.ExitStack() as stack:

        def start(scenario: Path | str = NOMINAL, speed: str = "max") -> EmulatedRig:
            kind = Path(scenario).resolve(), str(speed)
            if kind not in running:
                folder = tmp_path_factory.mktemp("jointscope")
                running[kind] = stack.enter_context(emulated_service(folder, *kind))
            return running[kind]

        yield start


@pytest.fixture
def emulated_rig(
    request: pytest.FixtureRequest, emulated_rigs: Callable[..., "EmulatedRig"]
) -> Iterator["EmulatedRig"]:
    """Give an emulated rig at rest, held by nobody; the mark `emulated_rig` chooses scenario and speed."""
    rig = emulated_rigs(**_choices(request))
    yield rig
    rig.rest()


@pytest.fixture
def emulated_port(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """Give the serial port of an emulated controller of its own, for code that speaks the protocol itself."""
    from jointscope_client.emulated_service import NOMINAL, emulated_controller

    choices = _choices(request)
    with emulated_controller(
        tmp_path, Path(choices.get("scenario", NOMINAL)), choices.get("speed", "max")
    ) as port:
        yield port


def _choices(request: pytest.FixtureRequest) -> dict[str, str]:
    mark = request.node.get_closest_marker(MARK)
    return {} if mark is None else dict(mark.kwargs)
