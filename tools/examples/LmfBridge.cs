// A bridge from truepose to Leica trackers of LMF: AT930, AT960, AT40x, AT500, ATS600. It runs on Windows with Leica's SDK.
//
//     csc -r:LMF.Tracker.Connection.dll -r:System.Web.Extensions.dll LmfBridge.cs Bridge.cs      (or mcs)
//     LmfBridge.exe 0.0.0.0:7700 192.168.0.1        the tracker's address; AT960LRSimulator is Leica's own simulator
//
// Bridge.cs holds the lines that are spoken with truepose, and calls CarryOut from a thread of its own: the SDK's calls block.
// Names are those of the SDK's public documentation. Not offered, or not known from it:
//
//     measure    needs a tracker with a profile of its own time (CustomStationaryMeasurementProfile), else it is not-offered
//     std_mm     Precision of a coordinate; no public source says of how many standard deviations it is
//     orientation  of a probe (T-Mac): Value0 is taken for w, its Precision for deg about each axis; no public source says either
//     locked     no target is selected, or the status is NotReady: an AT40x keeps its last target selected
//     events     beam-lost and beam-found; the SDK's warm-up state (AT40x) is not read
using System;
using System.Linq;
using LMF.Tracker;
using LMF.Tracker.Enums;
using LMF.Tracker.ErrorHandling;
using LMF.Tracker.MeasurementResults;
using LMF.Tracker.Measurements.Profiles;
using LMF.Units;
using Json = System.Collections.Generic.Dictionary<string, object>;

/// What truepose asks for, in calls of the SDK. mm, ms, deg C, mbar, %.
class LmfTracker : ITracker {
  readonly Tracker tracker;
  bool initialised;
  public event Action<bool> LockChanged = delegate {};

  public LmfTracker(string address) {
    tracker = new Connection().Connect(address);
    tracker.Settings.CoordinateType = ECoordinateType.Cartesian;
    tracker.Settings.RotationType = ERotationType.Quaternion;
    tracker.Settings.Units.AngleUnit = EAngleUnit.Degree;
    tracker.Settings.Units.LengthUnit = ELengthUnit.Millimeter;
    tracker.Settings.Units.TemperatureUnit = ETemperatureUnit.Celsius;
    tracker.Settings.Units.PressureUnit = EPressureUnit.mBar;
    tracker.Settings.Units.TimeUnit = ETimeUnit.Millisecond;
    tracker.PowerLock.UsePowerLock.Value = false;  // it would lock beyond search_mm
    tracker.Measurement.Status.Changed += (sender, status) => LockChanged(Locked);
    tracker.Disconnected += (sender, error) => Environment.Exit(1);
  }

  public Json Greeting() {
    return new Json { { "protocol", 1 }, { "bridge", "lmf-bridge 1.0" }, { "model", tracker.ProductName },
                      { "serial", tracker.SerialNumber }, { "firmware", tracker.InstalledFirmware } };
  }

  bool Locked {
    get { return tracker.Targets.Selected != null && tracker.Measurement.Status.Value != EMeasurementStatus.NotReady; }
  }

  public Json Status(bool busy) {
    var reasons = tracker.Measurement.Status.Preconditions;
    bool ready = initialised && reasons.Count <= (Locked ? 0 : 1);  // that nothing is locked is one
    string why = !initialised ? "it is not initialised" : reasons.Count > 0 ? reasons[0].Title + ": " + reasons[0].Solution : "";
    var names = Enumerable.Range(0, tracker.Targets.Count).Select(i => tracker.Targets[i]).Where(one => one.IsSelectable);
    return new Json { { "state", busy ? "busy" : ready ? "ready" : "not-ready" }, { "why", why }, { "initialised", initialised },
                      { "locked", Locked }, { "face", tracker.Face.IsFace1 ? 1 : 2 },
                      { "reflector", tracker.Targets.PreSelected == null ? "" : tracker.Targets.PreSelected.Name },
                      { "reflectors", names.Select(one => one.Name).ToArray() } };
  }

  /// One request. @return the members of its answer
  public Json CarryOut(string what, Json request) {
    Func<string, double> number = name => Convert.ToDouble(request[name]);
    if (what == "status") return Status(false);
    if (what == "initialise") {
      tracker.Initialize();
      initialised = true;
    } else if (what == "reflector") {
      var wanted = Enumerable.Range(0, tracker.Targets.Count).Select(i => tracker.Targets[i])
                             .FirstOrDefault(one => one.IsSelectable && one.Name == (string)request["name"]);
      if (wanted == null) throw new Refused("unknown-reflector", "the tracker knows no reflector \"" + request["name"] + "\"");
      wanted.Select();
    } else if (what == "air") {
      tracker.MeteoStation.Source.Value = EMeteoSource.ManualMeteo;
      tracker.MeteoStation.ManualTemperature.Value = number("temperature_c");
      tracker.MeteoStation.ManualPressure.Value = number("pressure_mbar");
      tracker.MeteoStation.ManualHumidity.Value = number("humidity_percent");
    } else if (!initialised) {
      throw new Refused("not-initialised", "the tracker is not initialised");
    } else if (what == "aim") {
      if (!tracker.Face.IsFace1) tracker.Face.Change();
      tracker.TargetSearch.Radius.Value = number("search_mm");
      tracker.TargetSearch.Timeout.Value = number("timeout_ms");
      var found = tracker.PositionTo(true, false, number("x"), number("y"), number("z"));
      if (found == null || !Locked) throw new Refused("no-target", "the search found no reflector");
    } else if (!Locked) {
      throw new Refused("no-target", "no reflector is locked");
    } else if (what == "face") {
      if (tracker.Face.IsFace1 != (number("face") == 1)) tracker.Face.Change();
      if (!Locked) tracker.TargetSearch.Start();
    } else {
      return Measure(number("time_ms"));
    }
    return new Json();
  }

  Json Measure(double timeMs) {
    var profiles = tracker.Measurement.Profiles;
    var all = Enumerable.Range(0, profiles.Count).Select(i => profiles[i]);
    var profile = all.OfType<CustomStationaryMeasurementProfile>().FirstOrDefault();
    if (profile == null) throw new Refused("not-offered", "this tracker has no measurement profile with a time of its own");
    profile.Time.Value = timeMs;
    profile.Select();
    var measured = tracker.Measurement.MeasureStationary();
    var point = measured as StationaryMeasurement3D;
    if (point == null) throw new Refused("failed", "the tracker measured no stationary point: " + measured.GetType().Name);
    var at = point.Position;
    var std = new Json { { "x", at.Coordinate1.Precision }, { "y", at.Coordinate2.Precision }, { "z", at.Coordinate3.Precision } };
    var answer = new Json { { "x", at.Coordinate1.Value }, { "y", at.Coordinate2.Value }, { "z", at.Coordinate3.Value }, { "std_mm", std },
                            { "averaged_ms", timeMs }, { "age_ms", 0 }, { "temperature_c", measured.Temperature.Value },
                            { "pressure_mbar", measured.Pressure.Value }, { "humidity_percent", measured.Humidity.Value } };
    var pose = measured as StationaryMeasurement6D;
    if (pose == null) return answer;
    var turned = pose.Rotation;
    answer["orientation"] = new Json { { "w", turned.Value0.Value }, { "x", turned.Value1.Value }, { "y", turned.Value2.Value },
                                       { "z", turned.Value3.Value }, { "std_deg", turned.Precision.Value } };
    return answer;
  }

  public void Interrupt() {
    tracker.Measurement.StopMeasurement();
    tracker.TargetSearch.Stop();
  }

  public Refused Meaning(Exception error, string what) {
    var lmf = error as LmfException;
    if (lmf == null) return new Refused("failed", error.Message);
    if (!Locked) LockChanged(false);  // before the refusal, whenever the SDK's own event comes
    string code = what == "aim" || what == "face" ? "no-target" : what == "measure" && !Locked ? "beam-broken" : "failed";
    return new Refused(code, lmf.Title + " (LMF " + lmf.Number + "): " + lmf.Description);
  }

  static void Main(string[] words) {
    string[] listen = words[0].Split(':');
    new Bridge(new LmfTracker(words[1])).Serve(listen[0], int.Parse(listen[1]));
  }
}
