"""Ask what a joint's model lacks: upload model and measurements, wait for the analysis, save its report.

python -m examples.start_analysis config/models/joint1.yaml train.parquet test.parquet report.html
"""

import asyncio
import sys
from pathlib import Path

from jointscope_client.async_client import AsyncClient


async def analyse(model_file: str, train_file: str, test_file: str, report_file: str) -> None:
    """Print the verdict and what the model got."""
    async with AsyncClient() as client:
        model = await client.models.add(Path(model_file).read_text(encoding="utf-8"), note="nameplate")
        train, test = await asyncio.gather(
            client.recordings.upload(Path(train_file)), client.recordings.upload(Path(test_file))
        )
        analysis = await client.discrepancies.start(model.id, [train.id], [test.id])
        done = await client.discrepancies.wait(
            analysis.id, lambda view: print(view.state, view.progress.get("text", ""))
        )
        print(f"verdict: {done.result['verdict']}; effects: {', '.join(done.result['effects']) or 'none'}")
        if done.model_id is not None:
            extended = await client.models.get(done.model_id)
            print(f"{extended.name} is now at version {extended.version}")
        report = await client.discrepancies.report(analysis.id)
        await asyncio.to_thread(Path(report_file).write_text, report, encoding="utf-8")


if __name__ == "__main__":
    asyncio.run(analyse(*sys.argv[1:]))
