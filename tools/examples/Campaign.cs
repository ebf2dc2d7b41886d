// Runs a calibration campaign at a truepose daemon, follows it, keeps its report, and activates the model that it made.
//
//     mcs -r:System.Web.Extensions Campaign.cs && mono Campaign.exe HOST:PORT TOKEN_FILE REPORT.json [IDENTIFY VALIDATE]
//
// On the daemon's own machine. From elsewhere the stream becomes an SslStream before the first line, which needs .NET 5 or later:
// the daemon speaks TLS 1.3 alone, Mono does not know it. There System.Text.Json takes JavaScriptSerializer's place.
// proto/control/reference.md has each method and event.
using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Net.Sockets;
using System.Text;
using System.Web.Script.Serialization;
using Json = System.Collections.Generic.Dictionary<string, object>;

class Refused : Exception {
  public Refused(string message) : base(message) {}
}

/// One connection: JSON-RPC 2.0, one object a line. Events that come while an answer is waited for are kept.
class Daemon {
  readonly JavaScriptSerializer json = new JavaScriptSerializer { MaxJsonLength = int.MaxValue };
  readonly Queue<Json> events = new Queue<Json>();
  readonly Stream stream;
  readonly StreamReader lines;
  int lastId;

  public Daemon(string host, int port, string token) {
    stream = new TcpClient(host, port) { NoDelay = true }.GetStream();
    lines = new StreamReader(stream, new UTF8Encoding(false));
    Call("session.hello", new Json { { "protocol", 1 }, { "token", token } });
  }

  public Json Call(string method, Json parameters = null) {
    int id = ++lastId;
    var request = new Json { { "jsonrpc", "2.0" }, { "id", id }, { "method", method }, { "params", parameters ?? new Json() } };
    byte[] line = Encoding.UTF8.GetBytes(json.Serialize(request) + "\n");
    stream.Write(line, 0, line.Length);
    while (true) {
      Json message = Read();
      object given;
      if (!message.TryGetValue("id", out given) || !Equals(given, id)) continue;  // an event, or what a later daemon tells
      if (message.ContainsKey("error")) throw new Refused((string)((Json)message["error"])["message"]);
      return (Json)message["result"];
    }
  }

  /// A call that changes something: with a name, by which the daemon would know it again if it came twice.
  public Json Command(string method, Json parameters = null) {
    return Call(method, new Json(parameters ?? new Json()) { { "command_id", Guid.NewGuid().ToString() } });
  }

  public Json NextEvent() {
    while (events.Count == 0) Read();
    return events.Dequeue();
  }

  Json Read() {
    string line = lines.ReadLine();
    if (line == null) throw new IOException("the daemon closed the connection");
    var message = json.Deserialize<Json>(line);
    if (message.ContainsKey("method") && (string)message["method"] == "event") events.Enqueue((Json)message["params"]);
    return message;
  }
}

static class Campaign {
  static Json Follow(Daemon daemon, string campaign) {
    while (true) {
      var progress = (Json)daemon.NextEvent()["data"];
      if ((string)progress["id"] != campaign) continue;
      Console.WriteLine("{0}: {1} of {2} poses", progress["phase"], progress["done"], progress["total"]);
      if (new[] { "done", "aborted", "failed" }.Contains((string)progress["phase"])) return progress;
    }
  }

  static int Main(string[] words) {
    try {
      string[] at = words[0].Split(':');
      var daemon = new Daemon(at[0], int.Parse(at[1]), File.ReadAllText(words[1]).Trim());
      if ((string)daemon.Call("cell.status")["state"] == "disconnected") daemon.Command("cell.connect");
      daemon.Call("events.subscribe", new Json { { "topics", new[] { "campaign" } } });
      var wanted = new Json { { "activate", false } };
      if (words.Length > 4) {
        wanted["identify_poses"] = int.Parse(words[3]);
        wanted["validate_poses"] = int.Parse(words[4]);
      }
      string campaign = (string)daemon.Command("campaign.start", wanted)["id"];
      Json last = Follow(daemon, campaign);
      if ((string)last["phase"] != "done") throw new Refused("campaign " + last["phase"] + ": " + last["reason"]);
      Json report = daemon.Call("report.get", new Json { { "id", campaign } });
      File.WriteAllText(words[2], new JavaScriptSerializer { MaxJsonLength = int.MaxValue }.Serialize(report["document"]));
      Json model = daemon.Command("model.activate", new Json { { "id", last["model_id"] } });
      Console.WriteLine("model {0} is active", model["id"]);
      return 0;
    } catch (Exception error) when (error is Refused || error is IOException || error is SocketException) {
      Console.Error.WriteLine("Campaign: " + error.Message);
      return 1;
    }
  }
}
