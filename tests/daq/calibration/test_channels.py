"""Counts become SI by the dictionary's scales or by the rig's own."""

import numpy as np
import pytest

from daq.calibration.channels import calibrate_channels, counts_to_si
from daq.errors import RecordingError
from daq.protocol.dictionary_entries import Channel, CountType

POSITION = Channel(
    name="position",
    column="position_rad",
    unit="rad",
    type=CountType.U16,
    scale=20 * np.pi / 65536,
    offset=32768.0,
)


def test_ten_turns_of_counts_span_ten_turns() -> None:
    (calibration,) = calibrate_channels([POSITION])
    counts = np.array([0, 32768, 65535], dtype=np.uint16)
    assert counts_to_si(counts, calibration).tolist() == [-10 * np.pi, 0.0, 32767 * 20 * np.pi / 65536]


def test_measured_scale_may_be_negative_and_names_its_source() -> None:
    measured = {"position": {"scale": -1e-3, "source": "turned by hand"}}
    (calibration,) = calibrate_channels([POSITION], measured)
    assert (calibration.scale, calibration.offset_counts, calibration.source) == (
        -1e-3,
        32768.0,
        "turned by hand",
    )


@pytest.mark.parametrize(
    ("measured", "message"),
    [
        ({"torque": {"scale": 1.0}}, "unknown channel 'torque'; the stream has position"),
        ({"position": {"gain": 1.0}}, "unknown fields gain; known are scale, offset_counts, source"),
        ({"position": {"scale": 0.0}}, "scale=0.0 .* the scale not 0"),
        ({"position": {"offset_counts": float("nan")}}, "offset_counts=nan must be finite"),
    ],
)
def test_wrong_calibration_is_refused(measured: dict[str, dict[str, float]], message: str) -> None:
    with pytest.raises(RecordingError, match=message):
        calibrate_channels([POSITION], measured)
