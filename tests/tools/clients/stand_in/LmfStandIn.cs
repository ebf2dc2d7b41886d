// Leica's LMF as LmfBridge.cs meets it: the public types of LMF.Tracker.Connection.dll that it uses, on the simulated tracker.
//
// Names are those of the assembly's XML documentation and of a public program that uses it (Engbretson/laserTracker). What is
// behind them is truepose-sim's bridge port, whose address is in TRUEPOSE_SIM_BRIDGE. As in the SDK, calls block and throw
// LmfException, and events come from a thread of its own.
using System;
using System.Collections.Generic;
using System.IO;
using System.Net.Sockets;
using System.Text;
using System.Threading;
using System.Web.Script.Serialization;
using Json = System.Collections.Generic.Dictionary<string, object>;

namespace LMF.Units {
  public enum ECoordinateType { Spherical, Cartesian, Cylindrical }
  public enum ERotationType { RotationAngles, RollPitchYaw, Quaternion }
  public enum EAngleUnit { Radian, Degree, Gon }
  public enum ELengthUnit { Meter, Millimeter, Micrometer, Foot, Yard, Inch }
  public enum ETemperatureUnit { Celsius, Fahrenheit }
  public enum EPressureUnit { mBar, HPascal, KPascal, MmHg, Psi, InH2O, InHg }
  public enum ETimeUnit { Millisecond, Second, Minute, Hour }
  public class Units {
    public EAngleUnit AngleUnit { get; set; }
    public ELengthUnit LengthUnit { get; set; }
    public ETemperatureUnit TemperatureUnit { get; set; }
    public EPressureUnit PressureUnit { get; set; }
    public ETimeUnit TimeUnit { get; set; }
  }
}

namespace LMF.Tracker.Enums {
  public enum EMeasurementStatus { ReadyToMeasure, MeasurementInProgress, NotReady, Invalid }
  public enum EMeteoSource { ManualMeteo, LiveMeteo }
}

namespace LMF.Tracker.ErrorHandling {
  public class LmfException : Exception {
    public int Number { get; private set; }
    public string Title { get; private set; }
    public string Description { get; private set; }
    public string Solution { get; private set; }
    public LmfException(int number, string title, string description) : base(title) {
      Number = number;
      Title = title;
      Description = description;
      Solution = "";
    }
  }
}

namespace LMF.Tracker.BasicTypes.DoubleValue {
  public class DoubleValueWithRange { public double Value { get; set; } }
  public class SimpleDoubleValue { public double Value { get; internal set; } }
  public class StationaryStatisticDoubleValue : SimpleDoubleValue { public double Precision { get; internal set; } }
}

namespace LMF.Tracker.BasicTypes.BoolValue {
  public class BoolValue { public bool Value { get; set; } }
}

namespace LMF.Tracker.MeasurementResults {
  using LMF.Tracker.BasicTypes.DoubleValue;
  public class Measurement {
    public SimpleDoubleValue Temperature { get; internal set; }
    public SimpleDoubleValue Pressure { get; internal set; }
    public SimpleDoubleValue Humidity { get; internal set; }
  }
  public class StationaryPosition {
    public StationaryStatisticDoubleValue Coordinate1 { get; internal set; }
    public StationaryStatisticDoubleValue Coordinate2 { get; internal set; }
    public StationaryStatisticDoubleValue Coordinate3 { get; internal set; }
  }
  public class StationaryMeasurement3D : Measurement { public StationaryPosition Position { get; internal set; } }
  public class StationaryRotation {
    public SimpleDoubleValue Value0 { get; internal set; }
    public SimpleDoubleValue Value1 { get; internal set; }
    public SimpleDoubleValue Value2 { get; internal set; }
    public SimpleDoubleValue Value3 { get; internal set; }
    public SimpleDoubleValue Precision { get; internal set; }
  }
  public class StationaryMeasurement6D : StationaryMeasurement3D { public StationaryRotation Rotation { get; internal set; } }
}

namespace LMF.Tracker.Targets {
  using LMF.Tracker.BasicTypes.DoubleValue;
  public class Target {
    internal Simulated Tracker;
    public string Name { get; internal set; }
    public bool IsSelectable { get { return true; } }
    public void Select() { Tracker.Ask("reflector", new Json { { "name", Name } }); }
  }
  public class TargetCollection {
    internal Simulated Tracker;
    object[] Names { get { return ((System.Collections.ArrayList)Tracker.Ask("status")["reflectors"]).ToArray(); } }
    Target Named(string name) { return new Target { Tracker = Tracker, Name = name }; }
    public int Count { get { return Names.Length; } }
    public Target this[int index] { get { return Named((string)Names[index]); } }
    public Target PreSelected { get { return Named((string)Tracker.Ask("status")["reflector"]); } }
    public Target Selected { get { return Tracker.Locked ? PreSelected : null; } }
  }
  public class TargetSearch {
    internal Simulated Tracker;
    public readonly DoubleValueWithRange Radius = new DoubleValueWithRange(), Timeout = new DoubleValueWithRange();
    public Target Start() { throw new LMF.Tracker.ErrorHandling.LmfException(1, "Target not found", "The search found no target."); }
    public void Stop() { Tracker.Ask("stop"); }
  }
}

namespace LMF.Tracker.Measurements.Profiles {
  using LMF.Tracker.BasicTypes.DoubleValue;
  public class MeasurementProfile {
    internal MeasurementProfileCollection All;
    public void Select() { All.Selected = this; }
  }
  public class StationaryMeasurementProfile : MeasurementProfile {}
  public class CustomStationaryMeasurementProfile : MeasurementProfile {
    public readonly DoubleValueWithRange Time = new DoubleValueWithRange();
  }
  public class MeasurementProfileCollection {
    readonly MeasurementProfile[] all;
    public MeasurementProfile Selected { get; internal set; }
    public MeasurementProfileCollection() {
      all = new MeasurementProfile[] { new StationaryMeasurementProfile { All = this }, new CustomStationaryMeasurementProfile { All = this } };
      Selected = all[0];
    }
    public int Count { get { return all.Length; } }
    public MeasurementProfile this[int index] { get { return all[index]; } }
  }
}

namespace LMF.Tracker.MeasurementStatus {
  using LMF.Tracker.Enums;
  public class MeasurementPrecondition {
    public int Number { get { return 1; } }
    public string Title { get { return "No target"; } }
    public string Description { get { return "No target is locked."; } }
    public string Solution { get { return "Lock a target."; } }
  }
  public class MeasurementPreconditionCollection {
    public int Count { get; internal set; }
    public MeasurementPrecondition this[int index] { get { return new MeasurementPrecondition(); } }
  }
  public class MeasurementStatusValue {
    internal Simulated Tracker;
    public delegate void ChangedEventHandler(MeasurementStatusValue sender, EMeasurementStatus value);
    public event ChangedEventHandler Changed = delegate {};
    public EMeasurementStatus Value { get { return Tracker.Locked ? EMeasurementStatus.ReadyToMeasure : EMeasurementStatus.NotReady; } }
    public MeasurementPreconditionCollection Preconditions {
      get { return new MeasurementPreconditionCollection { Count = Tracker.Locked ? 0 : 1 }; }
    }
    internal void Raise() { Changed(this, Value); }
  }
}

namespace LMF.Tracker.Measurements {
  using LMF.Tracker.BasicTypes.DoubleValue;
  using LMF.Tracker.MeasurementResults;
  using LMF.Tracker.Measurements.Profiles;
  public class MeasurementSettings {
    internal Simulated Tracker;
    public MeasurementStatus.MeasurementStatusValue Status { get; internal set; }
    public readonly MeasurementProfileCollection Profiles = new MeasurementProfileCollection();
    public void StopMeasurement() { Tracker.Ask("stop"); }
    public Measurement MeasureStationary() {
      var custom = Profiles.Selected as CustomStationaryMeasurementProfile;
      Json at = Tracker.Ask("measure", new Json { { "time_ms", custom == null ? 2000 : custom.Time.Value } });
      var std = (Json)at["std_mm"];
      Func<string, SimpleDoubleValue> value = name => new SimpleDoubleValue { Value = Convert.ToDouble(at[name]) };
      Func<string, StationaryStatisticDoubleValue> coordinate = axis => new StationaryStatisticDoubleValue {
        Value = Convert.ToDouble(at[axis]), Precision = Convert.ToDouble(std[axis]) };
      var point = at.ContainsKey("orientation") ? new StationaryMeasurement6D { Rotation = Rotation((Json)at["orientation"]) }
                                                : new StationaryMeasurement3D();
      point.Temperature = value("temperature_c");
      point.Pressure = value("pressure_mbar");
      point.Humidity = value("humidity_percent");
      point.Position = new StationaryPosition { Coordinate1 = coordinate("x"), Coordinate2 = coordinate("y"), Coordinate3 = coordinate("z") };
      return point;
    }
    static StationaryRotation Rotation(Json turned) {
      Func<string, SimpleDoubleValue> value = name => new SimpleDoubleValue { Value = Convert.ToDouble(turned[name]) };
      return new StationaryRotation { Value0 = value("w"), Value1 = value("x"), Value2 = value("y"), Value3 = value("z"),
                                      Precision = value("std_deg") };
    }
  }
}

namespace LMF.Tracker.Meteo {
  using LMF.Tracker.Enums;
  public class MeteoSource { public EMeteoSource Value { get; set; } }
  public class ManualEnvironmentalSensor {
    readonly Action changed;
    double value;
    internal ManualEnvironmentalSensor(double value, Action changed) {
      this.value = value;
      this.changed = changed;
    }
    public double Value {
      get { return value; }
      set {
        this.value = value;
        changed();
      }
    }
  }
  public class MeteoStation {
    public readonly MeteoSource Source = new MeteoSource { Value = EMeteoSource.LiveMeteo };
    public readonly ManualEnvironmentalSensor ManualTemperature, ManualPressure, ManualHumidity;
    internal MeteoStation(Simulated tracker) {
      Action changed = () => {
        if (Source.Value == EMeteoSource.LiveMeteo) return;
        tracker.Ask("air", new Json { { "temperature_c", ManualTemperature.Value }, { "pressure_mbar", ManualPressure.Value },
                                      { "humidity_percent", ManualHumidity.Value } });
      };
      ManualTemperature = new ManualEnvironmentalSensor(20, changed);
      ManualPressure = new ManualEnvironmentalSensor(1013.25, changed);
      ManualHumidity = new ManualEnvironmentalSensor(50, changed);
    }
  }
}

namespace LMF.Tracker {
  using LMF.Tracker.ErrorHandling;

  public class Settings {
    public LMF.Units.ECoordinateType CoordinateType { get; set; }
    public LMF.Units.ERotationType RotationType { get; set; }
    public readonly LMF.Units.Units Units = new LMF.Units.Units();
  }
  public class PowerLock { public readonly BasicTypes.BoolValue.BoolValue UsePowerLock = new BasicTypes.BoolValue.BoolValue(); }
  public class Face {
    internal Simulated Tracker;
    public bool IsFace1 { get { return Convert.ToInt32(Tracker.Ask("status")["face"]) == 1; } }
    public void Change() { Tracker.Ask("face", new Json { { "face", IsFace1 ? 2 : 1 } }); }
  }

  public class Tracker {
    readonly Simulated simulated;
    public delegate void DisconnectedHandler(Tracker sender, LmfException error);
    public event DisconnectedHandler Disconnected = delegate {};
    public readonly Settings Settings = new Settings();
    public readonly PowerLock PowerLock = new PowerLock();
    public readonly Face Face;
    public readonly Targets.TargetCollection Targets;
    public readonly Targets.TargetSearch TargetSearch;
    public readonly Measurements.MeasurementSettings Measurement;
    public readonly Meteo.MeteoStation MeteoStation;
    public string ProductName { get { return "Simulated LMF tracker"; } }
    public string SerialNumber { get { return "390793"; } }
    public string InstalledFirmware { get { return "1.0"; } }

    internal Tracker(Simulated simulated) {
      this.simulated = simulated;
      Face = new Face { Tracker = simulated };
      Targets = new Targets.TargetCollection { Tracker = simulated };
      TargetSearch = new Targets.TargetSearch { Tracker = simulated };
      MeteoStation = new Meteo.MeteoStation(simulated);
      var status = new MeasurementStatus.MeasurementStatusValue { Tracker = simulated };
      Measurement = new Measurements.MeasurementSettings { Tracker = simulated, Status = status };
      simulated.Changed = status.Raise;
      simulated.Ended = () => Disconnected(this, null);
    }
    public void Initialize() { simulated.Ask("initialise"); }
    public Targets.Target PositionTo(bool searchTarget, bool isRelative, double pos1, double pos2, double pos3) {
      if (!searchTarget || isRelative) throw new LmfException(2, "Not simulated", "Only a search at a position is.");
      try {
        simulated.Ask("aim", new Json { { "x", pos1 }, { "y", pos2 }, { "z", pos3 }, { "search_mm", TargetSearch.Radius.Value },
                                        { "timeout_ms", TargetSearch.Timeout.Value } });
      } catch (LmfException error) when (error.Description == "no-target") {
        return null;
      }
      return Targets.Selected;
    }
  }

  public class Connection {
    public Tracker Connect(string connectionString) { return new Tracker(new Simulated()); }
  }

  /// A client of truepose-sim's bridge port, for calls from several threads.
  class Simulated {
    readonly Stream stream;
    readonly Dictionary<int, Json> answers = new Dictionary<int, Json>();
    int lastId;
    internal Action Changed = delegate {}, Ended = delegate {};

    internal Simulated() {
      string[] at = Environment.GetEnvironmentVariable("TRUEPOSE_SIM_BRIDGE").Split(':');
      stream = new TcpClient(at[0], int.Parse(at[1])) { NoDelay = true }.GetStream();
      new Thread(Read) { IsBackground = true }.Start();
      Ask("hello", new Json { { "protocol", 1 }, { "client", "LMF's stand-in" } });
    }

    internal bool Locked { get { return (bool)Ask("status")["locked"]; } }

    internal Json Ask(string what, Json members = null) {
      lock (answers) {
        int id = ++lastId;
        var request = new Json(members ?? new Json()) { { "id", id }, { "do", what } };
        byte[] line = Encoding.UTF8.GetBytes(new JavaScriptSerializer().Serialize(request) + "\n");
        stream.Write(line, 0, line.Length);
        while (!answers.ContainsKey(id)) Monitor.Wait(answers);
        Json answer = answers[id];
        answers.Remove(id);
        if (!(bool)answer["ok"]) throw new LmfException(100, (string)answer["text"], (string)answer["code"]);
        return answer;
      }
    }

    void Read() {
      var lines = new StreamReader(stream, new UTF8Encoding(false));
      string line;
      while ((line = lines.ReadLine()) != null) {
        var said = new JavaScriptSerializer().Deserialize<Json>(line);
        if (said.ContainsKey("event")) {
          ThreadPool.QueueUserWorkItem(_ => Changed());
          continue;
        }
        lock (answers) {
          answers[(int)said["id"]] = said;
          Monitor.PulseAll(answers);
        }
      }
      Ended();
    }
  }
}
