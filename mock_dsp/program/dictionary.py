"""What this controller announces about itself: channels, layouts, fault texts, generators, parameters."""

from daq.protocol.codes import CURRENT_COUNT_A, FaultBit, Generator, LayoutId
from daq.protocol.dictionary import Dictionary
from daq.protocol.dictionary_entries import Channel, CountType, FaultText, GeneratorName, Layout
from mock_dsp.control.parameters import POSITION_COUNTS, SPEED_SCALE_RAD_S
from mock_dsp.program.parameter_table import PARAMETERS

_TURN_RAD = 6.283185307179586
_POTENTIOMETER_TURNS = 10.0


def _current_channel(name: str, column: str) -> Channel:
    return Channel(name=name, column=column, unit="A", type=CountType.I16, scale=CURRENT_COUNT_A, offset=0.0)


CHANNELS: tuple[Channel, ...] = (
    _current_channel("current_ref", "current_ref_A"),
    _current_channel("current", "current_A"),
    Channel(
        name="position",
        column="position_rad",
        unit="rad",
        type=CountType.U16,
        scale=_POTENTIOMETER_TURNS * _TURN_RAD / POSITION_COUNTS,
        offset=POSITION_COUNTS / 2,
    ),
    _current_channel("phase_a", "current_phase_a_A"),
    _current_channel("phase_b", "current_phase_b_A"),
    Channel(
        name="speed",
        column="speed_controller_rad_s",
        unit="rad/s",
        type=CountType.I16,
        scale=SPEED_SCALE_RAD_S,
        offset=0.0,
    ),
)

LAYOUTS: tuple[Layout, ...] = (
    Layout(id=LayoutId.CONTROL, name="control", channels=("current_ref", "current", "position")),
    Layout(
        id=LayoutId.PHASES,
        name="phases",
        channels=("current_ref", "current", "position", "phase_a", "phase_b"),
    ),
    Layout(id=LayoutId.SPEED, name="speed", channels=("current_ref", "current", "position", "speed")),
)

FAULTS: tuple[FaultText, ...] = (
    FaultText(
        bit=FaultBit.OVER_CURRENT,
        name="over_current",
        text="A phase current passed over_current_A.",
        remedy="Check the motor cable and the current sensors for a short, then clear the fault.",
    ),
    FaultText(
        bit=FaultBit.OVER_SPEED,
        name="over_speed",
        text="The motor turned faster than speed_limit_rad_s.",
        remedy="Lower the excitation's amplitude or offset, or lengthen its period.",
    ),
    FaultText(
        bit=FaultBit.TRAVEL,
        name="travel",
        text="The joint left the range travel_min_rad to travel_max_rad.",
        remedy="Bring the joint back to the middle, then clear the fault; run with the centring loop on.",
    ),
    FaultText(
        bit=FaultBit.I2T,
        name="i2t",
        text="The motor current was above rated_current_A for too long.",
        remedy="Let the motor cool down; lower the excitation's rms current.",
    ),
    FaultText(
        bit=FaultBit.SENSOR,
        name="sensor",
        text="The position sensor is stuck.",
        remedy="Check the potentiometer and its supply.",
    ),
    FaultText(
        bit=FaultBit.BUS_VOLTAGE,
        name="bus_voltage",
        text="The DC link voltage is out of range.",
        remedy="Check the supply of the inverter.",
    ),
    FaultText(
        bit=FaultBit.ESTOP,
        name="estop",
        text="The emergency stop was pressed.",
        remedy="Make the rig safe, then clear the fault and arm again.",
    ),
    FaultText(
        bit=FaultBit.TEMPERATURE,
        name="temperature",
        text="The power stage is too hot.",
        remedy="Let it cool down and check its fan.",
    ),
    FaultText(
        bit=FaultBit.WATCHDOG,
        name="watchdog",
        text="The controller's background task stood still while the drive was on.",
        remedy="Report it with the recording: this is an error of the controller's program.",
    ),
)

DICTIONARY = Dictionary(
    device="Jointscope emulated controller",
    firmware="1.0.0",
    parameters=PARAMETERS,
    channels=CHANNELS,
    layouts=LAYOUTS,
    faults=FAULTS,
    generators=tuple(GeneratorName(id=generator, name=generator.name.lower()) for generator in Generator),
)
