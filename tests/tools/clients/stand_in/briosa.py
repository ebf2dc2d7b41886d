"""SpatialAnalyzer as truepose's bridge meets it: Briosa's client by name, signature and result, on the simulated tracker.

Names, arguments and results are those of the Python package of Briosa 0.3.0 for SA 2024.1.0508.5 (briosa-docs: api/python). What
is behind them is truepose-sim's bridge port, whose address is in TRUEPOSE_SIM_BRIDGE. Its profile measures for SHOT_MS, it searches
SEARCH_MM around where it was pointed, and its units are those of SA: degrees Fahrenheit, mmHg in and inHg out.
"""
import asyncio
import enum
import json
import os
from dataclasses import dataclass

SHOT_MS, SEARCH_MM, LIVE_MS = 500, 300.0, 10


class BriosaError(Exception):
    pass


class BriosaLifecycleError(BriosaError):
    pass


@dataclass(frozen=True)
class OperationFailure:
    operation_id: str
    diagnostic_code: str


class BriosaOperationError(BriosaError):
    def __init__(self, status_code, failure):
        super().__init__(f"Briosa operation '{failure.operation_id}' failed ({failure.diagnostic_code}).")
        self.status_code, self.failure = status_code, failure


class InstrumentPositionReportingFrame(str, enum.Enum):
    INSTRUMENT_BASE = "Instrument Base"
    WORLD = "World"
    WORKING = "Working"


@dataclass(frozen=True, kw_only=True)
class BriosaStartOptions:
    launch_spatial_analyzer: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class CollectionInstrumentId:
    collection_name: str
    instrument_id: int


@dataclass(frozen=True, slots=True, kw_only=True)
class PointName:
    collection_name: str
    group_name: str
    target_name: str


@dataclass(frozen=True, slots=True)
class Vector:
    x: float
    y: float
    z: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ActiveUnits:
    length: str
    angular: str
    temperature: str


@dataclass(frozen=True, slots=True, kw_only=True)
class LastInstrumentIndexResult:
    instrument_index: int
    instrument: CollectionInstrumentId


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentModelResult:
    name: str
    model: str


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentTargetStatus:
    is_locked: bool
    name: str
    number_of_faces: int
    locked_face: int


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentTargetsAndModeProfiles:
    mode_profiles: list
    target_names: list


@dataclass(frozen=True, slots=True, kw_only=True)
class InstrumentPositionUpdate:
    x_or_r: float
    y_or_theta: float
    z_or_phi: float
    time_since_update: float
    timestamp: str


@dataclass(frozen=True, slots=True, kw_only=True)
class GetPointCoordinateResult:
    vector_representation: Vector
    x_value: float
    y_value: float
    z_value: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ObservationInfo:
    instrument: CollectionInstrumentId
    active: bool
    timestamp: str
    rms_error: float
    temperature: float
    pressure: float
    relative_humidity: float
    info_data: str


class BriosaClient:
    async def start(self, options=None):
        host, port = os.environ["TRUEPOSE_SIM_BRIDGE"].rsplit(":", 1)
        self.reader, self.writer = await asyncio.open_connection(host, int(port))
        self.waiting, self.last_id, self.points, self.shots = {}, 0, {}, {}
        self.answers = asyncio.create_task(self._answers())
        await self._ask("hello", protocol=1, client="SpatialAnalyzer's stand-in")

    async def aclose(self):
        self.answers.cancel()
        self.writer.close()

    async def _answers(self):
        while line := await self.reader.readline():
            answer = json.loads(line)
            waiting = self.waiting.pop(answer.get("id"), None)
            if waiting and not waiting.done():
                waiting.set_result(answer)

    async def _ask(self, do, **members):
        self.last_id += 1
        answer = self.waiting[self.last_id] = asyncio.get_running_loop().create_future()
        self.writer.write(json.dumps({"id": self.last_id, "do": do} | members).encode() + b"\n")
        said = await answer
        if not said["ok"]:
            raise BriosaOperationError("aborted", OperationFailure(f"instrument_operations.{do}", said["code"]))
        return said

    async def get_last_instrument_index(self):
        return LastInstrumentIndexResult(instrument_index=0, instrument=CollectionInstrumentId(collection_name="A", instrument_id=0))

    async def get_instrument_id_from_name(self, name):
        return (await self.get_last_instrument_index()).instrument

    async def get_instrument_model(self, instrument):
        return InstrumentModelResult(name="A::0", model="Simulated tracker in SA")

    async def get_active_units(self):
        return ActiveUnits(length="millimeters", angular="degrees", temperature="fahrenheit")

    async def verify_instrument_connection(self, instrument):
        await self._ask("ping")
        return True

    async def start_instrument_interface(self, instrument, *, initialize_at_startup=False, device_ip_address=None, interface_type=0,
                                         run_in_simulation=False, allow_start_without_initialization_requirements=False):
        if initialize_at_startup:
            await self._ask("initialise")

    async def get_instrument_target_status(self, instrument):
        status = await self._ask("status")
        return InstrumentTargetStatus(is_locked=status["locked"], name=status["reflector"], number_of_faces=1, locked_face=0)

    async def get_instrument_targets_and_mode_profiles(self, instrument):
        return InstrumentTargetsAndModeProfiles(mode_profiles=["Single Pt. To SA"], target_names=(await self._ask("status"))["reflectors"])

    async def set_instrument_targeting(self, instrument, targeting_name):
        await self._ask("reflector", name=targeting_name)

    async def set_instrument_weather_setting(self, instrument, *, temperature=0.0, pressure=0.0, relative_humidity=0.0,
                                             set_automatically=False):
        await self._ask("air", temperature_c=(temperature - 32) * 5 / 9, pressure_mbar=pressure * 1013.25 / 760,
                        humidity_percent=relative_humidity)

    async def construct_point_in_working_coordinates(self, point_name, working_coordinates):
        if point_name in self.points:
            raise BriosaOperationError("failed", OperationFailure("construction_operations", "point exists"))
        self.points[point_name] = working_coordinates

    async def point_at_target(self, instrument, target_id, *, html_prompt_file=None):
        at = self.points[target_id]
        try:
            await self._ask("aim", x=at.x, y=at.y, z=at.z, search_mm=SEARCH_MM, timeout_ms=200)
        except BriosaOperationError as error:
            if error.failure.diagnostic_code != "no-target":
                raise

    async def get_current_instrument_position_update(self, instrument, *, reporting_frame=InstrumentPositionReportingFrame.INSTRUMENT_BASE,
                                                     polar_coordinates=False):
        at = await self._ask("measure", time_ms=LIVE_MS)
        return InstrumentPositionUpdate(x_or_r=at["x"], y_or_theta=at["y"], z_or_phi=at["z"], time_since_update=0, timestamp="")

    async def measure_single_point_here(self, instrument, target_id, *, measure_immediately=False, html_prompt_file=None):
        self.shots[target_id] = await self._ask("measure", time_ms=SHOT_MS)

    async def get_point_coordinate(self, point_name):
        at = self.shots[point_name]
        vector = Vector(at["x"], at["y"], at["z"])
        return GetPointCoordinateResult(vector_representation=vector, x_value=vector.x, y_value=vector.y, z_value=vector.z)

    async def get_observation_info(self, point, *, observation_index=0):
        at = self.shots[point]
        rms = (sum(sigma**2 for sigma in at["std_mm"].values())) ** 0.5
        return ObservationInfo(instrument=CollectionInstrumentId(collection_name="A", instrument_id=0), active=True, timestamp="",
                               rms_error=rms, temperature=at["temperature_c"] * 9 / 5 + 32, pressure=at["pressure_mbar"] / 33.863886667,
                               relative_humidity=at["humidity_percent"], info_data="")

    async def delete_measurements(self, instrument, point_name, *, delete_point_if_no_measurements_remain=False):
        del self.shots[point_name]

    async def stop_active_measurement_mode(self, instrument):
        await self._ask("stop")
