"""Generate `docs/effects.md` and the pictures in `docs/effects/` from the literal table.

python -m discrepancy.effects.document docs
"""

import argparse
from pathlib import Path

from discrepancy.effects.pictures.joint import INERTIA, TORQUE_CONSTANT, VISCOUS
from discrepancy.effects.pictures.spec import Picture
from discrepancy.effects.pictures.svg import write_svg
from discrepancy.effects.pictures.table import PICTURES
from discrepancy.effects.spec import Effect
from discrepancy.effects.table import EFFECTS

HEAD = f"""# The catalogue of effects

Generated from `discrepancy/effects/table.py` (`python -m discrepancy.effects.document docs`); do not edit. The joint
without any effect is J dw/dt = Kt i - B w. A torque written with a minus sign opposes the motion. On a linear axis read
m, N and kg for rad, N m and kg m^2.

The pictures are computed by the kernels that the search fits, for a joint of {INERTIA:g} kg m^2,
{VISCOUS:g} N m s/rad and {TORQUE_CONSTANT:g} N m/A. An opposing torque is positive where it brakes a positive speed;
dashed is the joint without the effect. The values under a picture hold where its legend says nothing else.
"""


def describe(effect: Effect) -> str:
    """Return the section of one effect."""
    rows = "\n".join(
        f"| `{p.name}` | {p.kind.value[0]} | {p.lower:.4g} .. {p.upper:.4g} | "
        f"{p.meaning}{'' if p.free else ' (from the starting grid)'} |"
        for p in effect.parameters
    )
    drivers = " and ".join(one for one in (effect.driver, effect.second_driver) if one is not None)
    confused = ", ".join(f"`{name}`" for name in effect.confused_with) or "nothing in the catalogue"
    return f"""## {effect.id}

`{effect.equation}`

{show(effect, PICTURES[effect.id](effect))}

Port: {effect.port.value}. Acts through: {drivers}. Signature: {effect.signature}.
Easily confused with: {confused}. Judged by torque: {"yes" if effect.inverse else "no"}. Reference: {effect.reference}.

| parameter | unit | bounds | meaning |
|---|---|---|---|
{rows}
"""


def show(effect: Effect, picture: Picture) -> str:
    """Return the reference to the picture of an effect, and the values that it is drawn with."""
    values = []
    for parameter in effect.parameters:
        unit = parameter.kind.value[0]
        number = f"{picture.values[parameter.name]:.3g}"
        values.append(f"`{parameter.name}` {number}" + ("" if unit == "1" else f" {unit}"))
    alt = f"{effect.id}: {picture.title}"
    return f"![{alt}](effects/{effect.id}.svg)\n\nDrawn with {', '.join(values)}."


def document() -> str:
    """Return the page."""
    return "\n".join([HEAD, *(describe(effect) for effect in EFFECTS.values())])


def write_document(folder: Path) -> list[Path]:
    """Write `effects.md` and `effects/ID.svg` into a folder; return what was written. Other files stay.

    Raises:
        OSError: the folder cannot be written.
    """
    pictures = folder / "effects"
    pictures.mkdir(parents=True, exist_ok=True)
    texts = {folder / "effects.md": document()}
    for name, effect in EFFECTS.items():
        texts[pictures / f"{name}.svg"] = write_svg(PICTURES[name](effect))
    for path, text in texts.items():
        path.write_text(text, encoding="utf-8", newline="\n")
    return list(texts)


def main() -> None:
    """Write page and pictures into the folder that was named."""
    parser = argparse.ArgumentParser(
        prog="python -m discrepancy.effects.document",
        description="Write the catalogue of effects: effects.md, and a picture of each effect in effects/.",
        epilog="example: python -m discrepancy.effects.document docs",
    )
    parser.add_argument("folder", type=Path, help="folder to write into; made if it is not there")
    folder = parser.parse_args().folder
    try:
        write_document(folder)
    except OSError as error:
        parser.exit(1, f"cannot write the catalogue into {folder}: {error}\n")


if __name__ == "__main__":
    main()
