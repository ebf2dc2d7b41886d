// The half of a bridge that has nothing to do with a tracker: the lines of docs/trackers.md, for one client at a time.
//
// A tracker is an ITracker. Its calls block, as those of a maker's SDK do, and come from a thread of their own: the thread that
// reads answers ping, hello and status meanwhile. LmfBridge.cs is an example.
using System;
using System.Collections.Concurrent;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Net;
using System.Net.Sockets;
using System.Text;
using System.Threading;
using System.Web.Script.Serialization;
using Json = System.Collections.Generic.Dictionary<string, object>;

/// Why a request is not carried out: a code of the page, and one sentence for the operator.
class Refused : Exception {
  public readonly string Code;
  public Refused(string code, string text) : base(text) { Code = code; }
}

interface ITracker {
  Json Greeting();
  /// From any thread.
  Json Status(bool busy);
  /// One request, to its end. @return the members of its answer. Throws Refused, or what the SDK throws.
  Json CarryOut(string what, Json request);
  /// Ends CarryOut soon. From another thread.
  void Interrupt();
  /// What the SDK threw.
  Refused Meaning(Exception error, string what);
  event Action<bool> LockChanged;
}

class Bridge {
  static readonly Dictionary<string, string[]> Members = new Dictionary<string, string[]> {
    { "hello", new[] { "protocol" } }, { "ping", new string[0] }, { "status", new string[0] }, { "stop", new string[0] },
    { "initialise", new string[0] }, { "reflector", new[] { "name" } }, { "face", new[] { "face" } }, { "measure", new[] { "time_ms" } },
    { "air", new[] { "temperature_c", "pressure_mbar", "humidity_percent" } },
    { "aim", new[] { "x", "y", "z", "search_mm", "timeout_ms" } } };

  readonly ITracker tracker;
  readonly BlockingCollection<Action> calls = new BlockingCollection<Action>();
  readonly ManualResetEventSlim idle = new ManualResetEventSlim(true);
  readonly object turn = new object();  // of whoever sends a line or begins a call
  Stream client;                        // that is served
  bool interrupted, locked, greeted;

  public Bridge(ITracker tracker) {
    this.tracker = tracker;
    tracker.LockChanged += now => {
      lock (turn) {
        if (now != locked && client != null && greeted) Send(client, new Json { { "event", now ? "beam-found" : "beam-lost" } });
        locked = now;
      }
    };
    new Thread(() => { foreach (Action call in calls.GetConsumingEnumerable()) call(); }) { IsBackground = true }.Start();
  }

  public void Serve(string host, int port) {
    var listener = new TcpListener(IPAddress.Parse(host), port);
    listener.Start();
    Console.WriteLine("listening on port {0}", ((IPEndPoint)listener.LocalEndpoint).Port);
    while (true) {
      Stream stream = listener.AcceptTcpClient().GetStream();
      bool first;
      lock (turn) {
        first = client == null;
        if (first) client = stream;
      }
      if (first) {
        new Thread(() => Serve(stream)) { IsBackground = true }.Start();
      } else {
        Refuse(stream, null, new Refused("busy", "another client is connected"));
        stream.Close();
      }
    }
  }

  void Serve(Stream stream) {
    greeted = false;
    try {
      string line;
      var lines = new StreamReader(stream, new UTF8Encoding(false));
      while ((line = lines.ReadLine()) != null) Take(stream, line);
    } catch (IOException error) {
      Console.WriteLine("the client's connection ended: " + error.Message);
    }
    Stop();
    lock (turn) client = null;
    stream.Close();
  }

  void Take(Stream to, string line) {
    Json request = null;
    try {
      // Mono's serialiser takes an object that breaks off.
      if (line.TrimEnd().EndsWith("}")) request = new JavaScriptSerializer().Deserialize<Json>(line);
    } catch (ArgumentException) {  // no JSON
    } catch (InvalidOperationException) {
    }
    object id = request != null && request.ContainsKey("id") ? request["id"] : null;
    if (!(id is int) || (int)id < 1) {
      Refuse(to, null, new Refused("bad-request", "no JSON object with an id of 1 or more"));
      return;
    }
    string what = request.ContainsKey("do") ? request["do"] as string : null;
    string[] members = what != null && Members.ContainsKey(what) ? Members[what] : null;
    string wrong = members == null ? null : members.FirstOrDefault(name => !request.ContainsKey(name) || !Fits(name, request[name]));
    if (!greeted && what != "hello") {
      Refuse(to, id, new Refused("bad-request", "say hello first"));
    } else if (members == null) {
      Refuse(to, id, new Refused("not-offered", "there is no request \"" + what + "\""));
    } else if (wrong != null) {
      Refuse(to, id, new Refused("bad-request", what + ": " + wrong + " is missing or of another type"));
    } else if (what == "hello") {
      greeted = true;
      Answer(to, id, tracker.Greeting());
    } else if (what == "ping") {
      Answer(to, id, new Json());
    } else if (what == "stop") {
      new Thread(() => { Stop(); Answer(to, id, new Json()); }) { IsBackground = true }.Start();
    } else {
      Begin(to, id, what, request);
    }
  }

  static bool Fits(string name, object value) {
    return name == "name" ? value is string : value is int || value is long || value is double || value is decimal;
  }

  void Begin(Stream to, object id, string what, Json request) {
    lock (turn) {
      if (idle.IsSet) {
        idle.Reset();
        interrupted = false;
        calls.Add(() => CarryOut(to, id, what, request));
        return;
      }
    }
    if (what == "status") {
      Answer(to, id, tracker.Status(true));
    } else {
      Refuse(to, id, new Refused("busy", "the tracker does something else"));
    }
  }

  void CarryOut(Stream to, object id, string what, Json request) {
    Json answer = null;
    Refused refused = null;
    try {
      answer = tracker.CarryOut(what, request);
    } catch (Refused error) {
      refused = error;
    } catch (Exception error) {  // whatever the SDK throws, the request has to be answered
      refused = tracker.Meaning(error, what);
    }
    lock (turn) {
      if (interrupted) refused = new Refused("stopped", "stopped when asked to");
      if (refused == null) Answer(to, id, answer); else Refuse(to, id, refused);
      idle.Set();
    }
  }

  void Stop() {
    lock (turn) {
      if (idle.IsSet) return;
      interrupted = true;
    }
    tracker.Interrupt();
    idle.Wait();
  }

  void Answer(Stream to, object id, Json members) {
    Send(to, new Json(members) { { "id", id }, { "ok", true } });
  }

  void Refuse(Stream to, object id, Refused why) {
    Send(to, new Json { { "id", id }, { "ok", false }, { "code", why.Code }, { "text", why.Message } });
  }

  void Send(Stream to, Json line) {
    byte[] bytes = Encoding.UTF8.GetBytes(new JavaScriptSerializer().Serialize(line) + "\n");
    lock (turn) {
      try {
        to.Write(bytes, 0, bytes.Length);
      } catch (IOException) {  // its end is seen by the thread that reads
      }
    }
  }
}
