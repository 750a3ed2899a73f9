"""A study: every combination of arms, grid points, motions and laws, and the run that each stands for."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..checks import known_name, whole_number
from ..exceptions import StudyError
from ..scenario import Setup, changed
from ..scenario.setup import start_configuration, start_velocity
from ..simulation import Run, completed
from .cases import Case, Place, cases_of, chunk_size, part
from .definition import StudyDefinition, define, read_definition
from .identity import digest, identity
from .motions import Motion, RandomLines
from .warm import warm_up

if TYPE_CHECKING:
    import pyarrow as pa

    from .engine import ProgressCallback


class Study:
    """Arms × grid points × motions × laws: every combination is one run, and one row of the table.

    A run depends on the study and its own place in it alone: not on the number of processes, the machine or what was
    run before.

    Attributes:
        definition: What the study file holds.
        name: What the study is called.
        scenarios: The scenarios by name, with the laws of the study.
        points: What each grid point changes in them.
        identity: All that decides what the runs come to, as plain data.
        hash: SHA-256 of it: the definition, the scenarios and the robots.
    """

    def __init__(self, definition: StudyDefinition | Mapping[str, Any], name: str = "study") -> None:
        """Set up a study; the scenarios are read and the robots loaded.

        Args:
            definition: The fields of a study file.
            name: What it is called.

        Raises:
            StudyError: If it does not describe a study.
            AspectControlError: If a scenario or its robot cannot be read.
        """
        self.definition = definition if isinstance(definition, StudyDefinition) else define(name, definition)
        self.name = name
        self.scenarios = self.definition.load_scenarios()
        self.points = self.definition.points()
        self.identity = identity(self)
        self.hash = digest(self.identity)

    @classmethod
    def load(cls, path: str | Path) -> Study:
        """Read a study file, TOML; see `StudyDefinition`.

        Raises:
            StudyError: If the file is missing or malformed; the message names the field and what is allowed.
            AspectControlError: If a scenario or its robot cannot be read.
        """
        return cls(read_definition(path), Path(path).stem)

    @property
    def motions(self) -> int:
        """Number of motions of each scenario at each grid point."""
        return self.definition.motions.count

    @property
    def runs(self) -> int:
        """Number of runs."""
        return sum(map(len, self._cases.values())) * self.motions

    @property
    def chunk_size(self) -> int:
        """Number of runs that are done, and written, together."""
        return chunk_size(self.runs)

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return math.ceil(self.runs / self.chunk_size)

    def laws(self, scenario: str) -> tuple[str, ...]:
        """Return the labels of the laws of a scenario.

        Raises:
            UnknownNameError: If the study has no such scenario.
        """
        known_name(scenario, self.scenarios, "scenario", context=self.name)
        return tuple(each.run_label for each in self.scenarios[scenario].controllers)

    def describe(self) -> str:
        """Return the size of the study in words: `"400 runs: 1 scenario, 2 grid points, 40 motions, 5 laws"`."""
        laws = {law for scenario in self.scenarios for law in self.laws(scenario)}
        sizes = {"scenario": len(self.scenarios), "grid point": len(self.points), "motion": self.motions}
        sizes["law"] = len(laws)
        counted = (f"{size:,} {name}{'s' * (size != 1)}" for name, size in sizes.items())
        return f"{self.runs:,} runs: {', '.join(counted)}"

    def cases(self, scenario: str) -> tuple[Case, ...]:
        """Return what is run on every motion of a scenario, in the order of the table.

        Raises:
            UnknownNameError: If the study has no such scenario.
        """
        self.laws(scenario)
        return tuple(self._cases[scenario])

    def chunks_of(self, shard: str | None = None) -> Sequence[int]:
        """Return the chunks of the study, or of a part of it such as `"2/8"`.

        Raises:
            StudyError: If `shard` is no part.
        """
        return part(range(self.chunks), shard)

    def rows_of(self, chunk: int) -> range:
        """Return the numbers of the rows of a chunk."""
        return range(chunk * self.chunk_size, min((chunk + 1) * self.chunk_size, self.runs))

    def place(self, row: int) -> Place:
        """Return which run a row of the whole table stands for: scenario by scenario, motion by motion, case by case.

        Raises:
            ParameterError: If there is no such row.
        """
        rest = whole_number("row", row, 0, self.runs - 1)
        for cases in self._cases.values():
            if rest < len(cases) * self.motions:
                sample, index = divmod(rest, len(cases))
                return Place(cases[index].scenario, sample, cases[index].law, cases[index].point)
            rest -= len(cases) * self.motions
        raise AssertionError(row)

    def case(self, place: Place) -> Case:
        """Return the case that a run belongs to.

        Raises:
            UnknownNameError: If there is no such scenario or law.
            StudyError: If the law is not run at that grid point.
        """
        known_name(place.law, self.laws(place.scenario), "law", context=place.scenario)
        points = {case.point: case for case in self._cases[place.scenario] if case.law == place.law}
        if place.point not in points:
            raise StudyError(f"{place.law!r} is not run at grid point {place.point!r}, but at {sorted(points)}")
        return points[place.point]

    def setup(self, scenario: str, point: int = 0) -> Setup:
        """Return a scenario at a grid point, built.

        Raises:
            AspectControlError: If there is no such scenario or point, or something of it cannot be built.
        """
        known_name(scenario, self.scenarios, "scenario", context=self.name)
        return self._setups(scenario, whole_number("point", point, 0, len(self.points) - 1))

    def motion(self, scenario: str, sample: int, point: int = 0) -> Motion:
        """Return a motion of a scenario at a grid point.

        Raises:
            AspectControlError: If there is no such scenario, sample or point, or no line is found.
        """
        self.setup(scenario, point)
        return self._motions(scenario, whole_number("sample", sample, 0, self.motions - 1), point)

    def record(self, scenario: str, sample: int, law: str, point: int = 0, dt: float | None = None) -> Run:
        """Make a run of the study again, bit for bit, such as one that a row of the table makes look interesting.

        Args:
            scenario: Name of the scenario.
            sample: Number of the motion.
            law: Label of the law.
            point: Number of the grid point.
            dt: Sampling time if it is not to be that of the study, s.

        Raises:
            AspectControlError: If the study has no such run, or as `simulate` does.
        """
        self.case(Place(scenario, sample, law, point))
        setup, motion = self.setup(scenario, point), self.motion(scenario, sample, point)
        warm_up()
        return completed(motion.simulate(setup, law, dt))

    def run(
        self,
        out: str | Path | None = None,
        *,
        workers: int = 1,
        engine: str = "loky",
        scheduler: str | None = None,
        shard: str | None = None,
        resume: bool = True,
        progress: ProgressCallback | None = None,
    ) -> pa.Table:
        """Make the runs that are not there yet and return the table of all that are.

        The table does not depend on the number of processes, the engine or how often it was interrupted, but for the
        columns of versions and wall time. Runs are made with compiled kernels where Numba is installed: so are all
        torques of this process from then on, see `redundancy.compile_kernels`. With more than one worker a script of
        yours must call this under `if __name__ == "__main__":`.

        Args:
            out: Folder for the table, one Parquet file a chunk; what it holds of this study is not run again. None to
                keep the table in memory alone.
            workers: Number of processes of this machine; 1 for none but this one.
            engine: `"loky"` for this machine, `"dask"` for the workers of a Dask cluster.
            scheduler: Address of Dask's scheduler, such as `"tcp://10.0.0.1:8786"`.
            shard: Which part of the chunks to run, as `"2/8"`; None for all.
            resume: Whether to go on with what the folder holds; False makes it anew.
            progress: Called with a `StudyProgress` after every chunk.

        Returns:
            One row a run, in the order of `place`, see `studies.rows`.

        Raises:
            StudyError: If the folder holds another study, or the shard is none.
            WorkerError: If a worker process ended by itself, or the scheduler is not there or died; what was computed
                stays.
            OutputError: If the folder cannot be written to.
            AspectControlError: If a law, or anything else, cannot be built; this is found before the first run.
            KeyboardInterrupt: The user's Ctrl-C; what was computed stays.
        """
        from .engine import run_study

        return run_study(
            self,
            out,
            workers=workers,
            engine=engine,
            scheduler=scheduler,
            shard=shard,
            resume=resume,
            progress=progress,
        )

    def require_buildable(self) -> None:
        """Build everything once: the first law that cannot be built, or line that cannot be drawn, is an error.

        Raises:
            AspectControlError: If there is one.
        """
        for scenario in self.scenarios:
            for point in range(len(self.points)):
                self.motion(scenario, 0, point)

    @cached_property
    def _cases(self) -> dict[str, list[Case]]:
        return {name: cases_of(name, self.laws(name), self.points) for name in self.scenarios}

    @cached_property
    def _setups(self) -> Callable[[str, int], Setup]:
        return lru_cache(maxsize=64)(self._build)

    @cached_property
    def _motions(self) -> Callable[[str, int, int], Motion]:
        return lru_cache(maxsize=8)(self._draw)

    def _build(self, scenario: str, point: int) -> Setup:
        name = f"{scenario}, grid point {point}" if self.definition.grid else scenario
        setup = changed(name, self.scenarios[scenario], self.points[point]).build()
        endings = self.definition.endings
        if endings is None:
            return setup
        return replace(setup, events=tuple(event for event in setup.events if event.name in endings))

    def _draw(self, scenario: str, sample: int, point: int) -> Motion:
        setup, motions = self.setup(scenario, point), self.definition.motions
        if motions.random is not None:
            lines = RandomLines.after(scenario, setup.arm, setup.trajectory, motions.seed, motions.legs)
            return lines.draw(sample)
        if motions.given:
            given = motions.given[sample]
            q0, v0 = start_configuration(given.start, setup.arm), start_velocity(given.start, setup.arm)
            return Motion(q0, v0, given.trajectory.build())
        return Motion(setup.q0, setup.v0, setup.trajectory)

    def __getstate__(self) -> dict[str, Any]:
        """Return what a worker needs: it builds its own setups."""
        return {name: value for name, value in self.__dict__.items() if not name.startswith("_")}
