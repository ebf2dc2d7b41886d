#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <boost/json/object.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/math/refraction.hpp"
#include "core/named.hpp"
#include "proto/record/forms.hpp"
#include "proto/record/json_io.hpp"

/// The protocol of a bridge: a program on a tracker maker's SDK that makes a tracker of any kind look
/// alike. One JSON object a line (`\n`), UTF-8, over TCP; truepose connects. docs/trackers.md has
/// all of it.
///
///   {"id": 7, "do": "measure", "time_ms": 2000}        a request
///   {"id": 7, "ok": true, "x": 1000.0, ...}            its answer
///   {"id": 7, "ok": false, "code": "busy", "text": ""} or its refusal
///   {"event": "beam-lost", "text": ""}                 unasked
///
/// mm, ms, deg C, mbar, %; right-handed Cartesian coordinates in the tracker's own frame.
namespace truepose::bridge {

inline constexpr int kProtocol = 1;
/// Longest line either side may send, without its newline.
inline constexpr std::size_t kMaxLine = 64 * 1024;

// ---- What a bridge is asked. Each request names its answer.

/// An answer that says no more than that it was done.
struct Done {};

/// The first request of a connection.
struct Greeting;
struct Hello {
  static constexpr std::string_view kName = "hello";
  using Answer = Greeting;
  int protocol = kProtocol;  ///< the newest that the client speaks
  std::string client;        ///< for the bridge's log
};

/// Faults of the tracker that a bridge can be asked to simulate, to test a client.
enum class Rehearsal { BeamBreak, WarmedUp };
inline constexpr std::array kRehearsals{Named{"beam-break", Rehearsal::BeamBreak},
                                        Named{"warmed-up", Rehearsal::WarmedUp}};

struct Greeting {
  int protocol = kProtocol;  ///< that is spoken from now on
  std::string bridge;        ///< its name and version
  std::string model, serial, firmware;
  std::vector<Rehearsal> rehearses;
};

/// What the tracker could do now.
enum class State { Ready, Busy, WarmingUp, NotReady };
inline constexpr std::array kStates{Named{"ready", State::Ready}, Named{"busy", State::Busy},
                                    Named{"warming-up", State::WarmingUp},
                                    Named{"not-ready", State::NotReady}};

struct Status {
  State state = State::NotReady;  ///< whether it could measure, were a reflector locked
  std::string why;                ///< one sentence for the operator, where it is not ready
  bool initialised = false;
  bool locked = false;
  int face = 0;                         ///< 1 or 2; 0: not known
  std::string reflector;                ///< that is selected; empty: none
  std::vector<std::string> reflectors;  ///< that it knows
};
struct GetStatus {
  static constexpr std::string_view kName = "status";
  using Answer = Status;
};

struct Initialise {
  static constexpr std::string_view kName = "initialise";
  using Answer = Done;
};

struct SetReflector {
  static constexpr std::string_view kName = "reflector";
  using Answer = Done;
  std::string name;
};

/// The air by which distances are to be corrected from now on.
struct SetAir {
  static constexpr std::string_view kName = "air";
  using Answer = Done;
  Air air;
};

/// Point there in face 1, search within the radius, and answer once a reflector is locked.
struct DoAim {
  static constexpr std::string_view kName = "aim";
  using Answer = Done;
  Eigen::Vector3d p_W_mm{0, 0, 0};
  double search_mm = 0;
  std::chrono::milliseconds timeout{10'000};  ///< of the search
};

/// How a 6-D target (T-Mac, STS, a camera's marker) is turned: a unit quaternion that takes its axes to the
/// tracker's.
struct Orientation {
  double w = 1, x = 0, y = 0, z = 0;
  double std_deg = 0;  ///< standard deviation of a rotation about each axis

  Eigen::Matrix3d rotation() const { return Eigen::Quaterniond{w, x, y, z}.normalized().toRotationMatrix(); }
};

/// One stationary measurement.
struct Measured {
  Eigen::Vector3d p_W_mm{0, 0, 0};
  /// Of the measurement; one of the two.
  std::optional<Eigen::Vector3d> std_mm;
  std::optional<Eigen::Matrix<double, 6, 1>> covariance_mm2;  ///< xx, xy, xz, yy, yz, zz
  std::optional<Orientation> orientation;                     ///< of a 6-D target
  std::chrono::milliseconds averaged{0};                      ///< over so much time
  std::chrono::milliseconds age{0};                           ///< since it ended
  Air air;                                                    ///< by which its distance was corrected

  Eigen::Vector3d deviations_mm() const;
};
struct DoMeasure {
  static constexpr std::string_view kName = "measure";
  using Answer = Measured;
  std::chrono::milliseconds time{2000};  ///< to average over, at least
};

/// Turn over into this face and lock the same reflector again.
struct SetFace {
  static constexpr std::string_view kName = "face";
  using Answer = Done;
  int face = 1;
};

/// End what is under way, which is refused with `stopped`.
struct Stop {
  static constexpr std::string_view kName = "stop";
  using Answer = Done;
};

/// Answered at once, whatever else is under way.
struct Ping {
  static constexpr std::string_view kName = "ping";
  using Answer = Done;
};

/// A fault that the greeting offered.
struct Rehearse {
  static constexpr std::string_view kName = "rehearse";
  using Answer = Done;
  Rehearsal what = Rehearsal::BeamBreak;
  std::chrono::milliseconds lasts{1000};
};

using Request = std::variant<Hello, GetStatus, Initialise, SetReflector, SetAir, DoAim, DoMeasure, SetFace,
                             Stop, Ping, Rehearse>;

// ---- Events and errors

enum class ErrorCode {
  Busy,
  NotReady,
  WarmingUp,
  NotInitialised,
  NoTarget,
  BeamBroken,
  UnknownReflector,
  OutOfRange,
  Stopped,
  NotOffered,
  BadRequest,
  WrongProtocol,
  DeviceLost,
  Failed,
};
inline constexpr std::array kErrorCodes{Named{"busy", ErrorCode::Busy},
                                        Named{"not-ready", ErrorCode::NotReady},
                                        Named{"warming-up", ErrorCode::WarmingUp},
                                        Named{"not-initialised", ErrorCode::NotInitialised},
                                        Named{"no-target", ErrorCode::NoTarget},
                                        Named{"beam-broken", ErrorCode::BeamBroken},
                                        Named{"unknown-reflector", ErrorCode::UnknownReflector},
                                        Named{"out-of-range", ErrorCode::OutOfRange},
                                        Named{"stopped", ErrorCode::Stopped},
                                        Named{"not-offered", ErrorCode::NotOffered},
                                        Named{"bad-request", ErrorCode::BadRequest},
                                        Named{"wrong-protocol", ErrorCode::WrongProtocol},
                                        Named{"device-lost", ErrorCode::DeviceLost},
                                        Named{"failed", ErrorCode::Failed}};

/// Why a request was not carried out. A code that this version does not know counts as Failed.
struct Refusal {
  std::string code;
  std::string text;  ///< one sentence for the operator, with the device's own number where there is one

  static Refusal of(ErrorCode code, std::string text) {
    return {std::string{name_of(kErrorCodes, code)}, std::move(text)};
  }
  ErrorCode meaning() const;
};

enum class EventKind {
  BeamLost,
  BeamFound,
  Busy,
  Ready,
  WarmingUp,
  WarmedUp,         ///< the tracker has to be initialised again
  SettingsChanged,  ///< by another client than this one: reflector, air or face
  Closing,          ///< the bridge ends
};
inline constexpr std::array kEvents{Named{"beam-lost", EventKind::BeamLost},
                                    Named{"beam-found", EventKind::BeamFound},
                                    Named{"busy", EventKind::Busy},
                                    Named{"ready", EventKind::Ready},
                                    Named{"warming-up", EventKind::WarmingUp},
                                    Named{"warmed-up", EventKind::WarmedUp},
                                    Named{"settings-changed", EventKind::SettingsChanged},
                                    Named{"closing", EventKind::Closing}};

/// One of a name that this version does not know is passed over.
struct Event {
  std::string event;
  std::string text;

  static Event of(EventKind kind, std::string text = {}) {
    return {std::string{name_of(kEvents, kind)}, std::move(text)};
  }
  std::optional<EventKind> kind() const;
};

// ---- Layouts

/// What is wrong with a unit quaternion, one phrase; empty: nothing.
std::string orientation_fault(const Orientation& orientation);
/// What is wrong with a covariance, one phrase; empty: nothing.
std::string covariance_fault(const Eigen::Matrix<double, 6, 1>& covariance_mm2);

void layout(record::Io&, Done&);
void layout(record::Io&, GetStatus&);
void layout(record::Io&, Initialise&);
void layout(record::Io&, Stop&);
void layout(record::Io&, Ping&);
void layout(record::Io& io, Hello& x);
void layout(record::Io& io, Greeting& x);
void layout(record::Io& io, Status& x);
void check(const record::Io& io, const Status& x);
void layout(record::Io& io, SetReflector& x);
void layout(record::Io& io, SetAir& x);
void layout(record::Io& io, DoAim& x);
void layout(record::Io& io, DoMeasure& x);
void layout(record::Io& io, Orientation& x);
void check(const record::Io& io, const Orientation& x);
void layout(record::Io& io, Measured& x);
void check(const record::Io& io, const Measured& x);
void layout(record::Io& io, SetFace& x);
void layout(record::Io& io, Rehearse& x);
void layout(record::Io& io, Refusal& x);
void layout(record::Io& io, Event& x);

// ---- Lines, without their newlines

std::string request_line(std::int64_t id, std::string_view name, boost::json::object members);
template <class Asked>
std::string encode(std::int64_t id, const Asked& request) {
  return request_line(id, Asked::kName, record::to_json(request));
}

std::string answer_line(std::int64_t id, boost::json::object members);
template <class Answer>
std::string encode_answer(std::int64_t id, const Answer& answer) {
  return answer_line(id, record::to_json(answer));
}
/// @param id  none where the request could not be read so far
std::string encode_refusal(std::optional<std::int64_t> id, const Refusal& refusal);
std::string encode(const Event& event);

struct Asked {
  std::int64_t id = 0;
  Request request;
};
/// A request that cannot be carried out as it stands, and what to answer.
struct BadRequestReply {
  std::optional<std::int64_t> id;
  Refusal refusal;
};
/// What a bridge was sent.
std::expected<Asked, BadRequestReply> decode_request(std::string_view line);

struct Reply {
  std::optional<std::int64_t> id;
  std::expected<boost::json::object, Refusal> outcome;  ///< the answer's members, see answer_of()
};
using FromBridge = std::variant<Reply, Event>;
/// What a bridge sent; or what is wrong with that, one phrase.
std::expected<FromBridge, std::string> decode_from_bridge(std::string_view line);

/// The answer to a request of this kind; or what is wrong with that, one phrase.
template <class Asked>
std::expected<typename Asked::Answer, std::string> answer_of(const boost::json::object& members) {
  return record::from_json<typename Asked::Answer>(boost::json::value(members));
}

}  // namespace truepose::bridge
