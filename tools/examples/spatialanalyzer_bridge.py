#!/usr/bin/env python3
"""A bridge from truepose to every laser tracker that SpatialAnalyzer (SA) drives: API, FARO, Leica and others.

    pip install briosa-2026-1-0529-7       # Briosa for your SA release, on the Windows PC that runs SA
    python spatialanalyzer_bridge.py --listen 0.0.0.0:7700 --instrument "Leica AT960" --shot-ms 1000

Before: start SA, add the tracker, choose a profile that measures a single point, switch its AutoLock (PowerLock, ATR) on.
SA shows millimeters, and its working frame is the tracker's base. bridge.py holds the lines that are spoken with truepose.
SA's interface does not give all that a bridge may offer:

    face              refused as not-offered: no call turns a tracker over
    aim               face 1 cannot be asked for; SA searches by its own settings, and what it locks beyond search_mm is refused
    time_ms           a profile has a time of its own, --shot-ms: shots are repeated and averaged until time_ms is reached
    std_mm            SA reports the RMS of a shot's samples: it stands for each axis, divided by the root of the number of shots
    orientation       of a 6-D target: SA makes a frame of it, and this bridge reads points alone
    serial, firmware  are not reported: --serial; firmware stays empty
    events            beam-lost and beam-found are asked for every 0.3 s; busy, warming-up and settings-changed are not reported
"""
import argparse
import asyncio
import math
import time

from briosa import (BriosaClient, BriosaOperationError, BriosaStartOptions, InstrumentPositionReportingFrame, PointName, Vector)

from bridge import Refused, serve

MMHG_PER_MBAR, MBAR_PER_INHG = 0.750061683, 33.8638867


class Tracker:
    """What truepose asks for, in calls of SA's interface. mm, ms, deg C, mbar, %."""

    not_offered = {"face": "SA's interface has no call that turns a tracker over"}

    def __init__(self, sa, instrument, shot_ms):
        self.sa, self.instrument, self.shot_ms = sa, instrument, shot_ms
        self.state = {"initialised": False, "locked": False, "face": 0, "reflector": "", "reflectors": []}
        self.wrong_lock = False  # what is locked is not what was asked for
        self.points = 0

    def new_point(self, kind):
        self.points += 1
        return PointName(collection_name=self.instrument.collection_name, group_name="truepose", target_name=f"{kind} {self.points}")

    async def look(self):
        """Brings the state up to date. Returns what SA says of the target."""
        if not await self.sa.verify_instrument_connection(self.instrument):
            self.state |= {"locked": False, "initialised": False}
            raise Refused("device-lost", "SA has lost the tracker: start its interface in SA")
        target = await self.sa.get_instrument_target_status(self.instrument)
        self.state |= {"locked": target.is_locked and not self.wrong_lock, "reflector": target.name}
        return target

    async def status(self):
        known = await self.sa.get_instrument_targets_and_mode_profiles(self.instrument)
        self.state["reflectors"] = list(known.target_names)
        try:
            await self.look()
        except Refused as refused:
            return self.state | {"state": "not-ready", "why": str(refused)}
        return self.state | {"state": "ready"}

    async def initialise(self):
        await self.sa.start_instrument_interface(self.instrument, initialize_at_startup=True)
        length = (await self.sa.get_active_units()).length
        if length.lower() != "millimeters":
            raise Refused("not-ready", f"SA shows {length}: choose millimeters in SA")
        self.state["initialised"] = True

    async def reflector(self, name):
        if name not in (await self.sa.get_instrument_targets_and_mode_profiles(self.instrument)).target_names:
            raise Refused("unknown-reflector", f'SA knows no target "{name}" for this tracker')
        await self.sa.set_instrument_targeting(self.instrument, name)

    async def air(self, temperature_c, pressure_mbar, humidity_percent):
        await self.sa.set_instrument_weather_setting(
            self.instrument, temperature=temperature_c * 1.8 + 32, pressure=pressure_mbar * MMHG_PER_MBAR,
            relative_humidity=humidity_percent, set_automatically=False)

    async def off_mm(self, wanted, frame):
        """How far the tracker's live position is from a point, both in that frame."""
        at = await self.sa.get_current_instrument_position_update(self.instrument, reporting_frame=frame)
        return math.dist((at.x_or_r, at.y_or_theta, at.z_or_phi), wanted)

    async def aim(self, x, y, z, search_mm, timeout_ms):
        if not self.state["initialised"]:
            raise Refused("not-initialised", "the tracker is not initialised")
        target, end = self.new_point("aim"), time.monotonic() + timeout_ms / 1000
        self.wrong_lock = True
        await self.sa.construct_point_in_working_coordinates(target, Vector(x, y, z))
        await self.sa.point_at_target(self.instrument, target)
        while not (await self.look()).is_locked:
            if time.monotonic() > end:
                raise Refused("no-target", "SA locked no reflector there: see that AutoLock is on")
            await asyncio.sleep(0.05)
        off_mm = await self.off_mm((x, y, z), InstrumentPositionReportingFrame.INSTRUMENT_BASE)
        if off_mm > search_mm:
            raise Refused("no-target", f"SA locked a reflector {off_mm:.1f} mm away ({search_mm} mm were allowed)")
        if await self.off_mm((x, y, z), InstrumentPositionReportingFrame.WORKING) > search_mm + 1:
            raise Refused("not-ready", "SA's working frame is not the tracker's base: choose that frame in SA")
        self.wrong_lock, self.state["locked"] = False, True

    async def measure(self, time_ms):
        await self.look()
        if not self.state["locked"]:
            raise Refused("no-target", "no reflector is locked")
        shots = [await self.shot() for _ in range(max(1, math.ceil(time_ms / self.shot_ms)))]
        mean = {axis: sum(getattr(at, f"{axis}_value") for at, _ in shots) / len(shots) for axis in "xyz"}
        std_mm = math.sqrt(sum(seen.rms_error**2 for _, seen in shots)) / len(shots)
        seen = shots[-1][1]
        return mean | {"std_mm": dict.fromkeys("xyz", std_mm), "averaged_ms": len(shots) * self.shot_ms, "age_ms": 0,
                       "temperature_c": (seen.temperature - 32) / 1.8, "pressure_mbar": seen.pressure * MBAR_PER_INHG,
                       "humidity_percent": seen.relative_humidity}

    async def shot(self):
        """One measurement of the profile: its point, and what SA noted of it."""
        target = self.new_point("shot")
        try:
            await self.sa.measure_single_point_here(self.instrument, target, measure_immediately=True)
        except BriosaOperationError as error:
            await self.look()
            raise Refused("failed" if self.state["locked"] else "beam-broken", f"SA could not measure ({error})") from error
        read = await self.sa.get_point_coordinate(target), await self.sa.get_observation_info(target)
        await self.sa.delete_measurements(self.instrument, target, delete_point_if_no_measurements_remain=True)
        return read

    async def interrupt(self):
        await self.sa.stop_active_measurement_mode(self.instrument)


async def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--listen", default="127.0.0.1:7700", metavar="HOST:PORT")
    parser.add_argument("--instrument", help="the tracker's name in SA; left out: the one that was added last")
    parser.add_argument("--shot-ms", type=int, default=1000, help="how long the chosen profile averages")
    parser.add_argument("--serial", default="not reported")
    options = parser.parse_args()
    host, port = options.listen.rsplit(":", 1)
    sa = BriosaClient()
    await sa.start(BriosaStartOptions(launch_spatial_analyzer=False))
    try:
        instrument = (await sa.get_instrument_id_from_name(options.instrument) if options.instrument
                      else (await sa.get_last_instrument_index()).instrument)
        model = (await sa.get_instrument_model(instrument)).model
        greeting = {"bridge": "spatialanalyzer-bridge 1.0", "model": model, "serial": options.serial, "firmware": ""}
        await serve(host, int(port), Tracker(sa, instrument, options.shot_ms), greeting)
    finally:
        await sa.aclose()


if __name__ == "__main__":
    try:
        asyncio.run(main())
    except KeyboardInterrupt:
        pass
