#pragma once

#include <array>
#include <string>
#include <string_view>

namespace truepose::daemon {

/// In the order of their codes.
enum class FaultCode {
  Access,
  Arm,
  Audit,
  Cell,
  Mode,
  Model,
  Store,
  StreamFrozen,
  StreamTimeout,
  StreamUnconfirmed,
  Tool,
  ToolData,
  Tracker,
};

/// What is the same of each fault of a code. docs/operate.md has this table; a test compares it.
struct FaultKind {
  std::string_view code;      ///< stable, for programs
  std::string_view severity;  ///< "warning" or "error"
  std::string_view meaning;
  std::string_view what_to_do;
};

inline constexpr std::array kFaultKinds{
    FaultKind{"E_ACCESS", "warning", "the access list cannot be used; the old one is used",
              "correct the file"},
    FaultKind{"E_ARM", "warning", "the arm's serial number is unknown",
              "load CellState and truepose_state of this version, or connect and arm again"},
    FaultKind{"E_AUDIT", "error", "the audit log was changed",
              "find the cause, then truepose audit acknowledge"},
    FaultKind{"E_CELL", "error", "robot, tracker, campaign or stream failed",
              "follow the sentence, then acknowledge and connect"},
    FaultKind{"E_MODE", "warning", "RSI and CellState name another operating mode",
              "load the RSI context of this version"},
    FaultKind{"E_MODEL", "error", "the active model is not the one that was made",
              "activate another, or identify again"},
    FaultKind{"E_STORE", "error", "the store or the disk cannot be written",
              "make room, then acknowledge and resume"},
    FaultKind{"E_STREAM_FROZEN", "warning", "the arm does not follow the correction",
              "remove the cause, then acknowledge"},
    FaultKind{"E_STREAM_TIMEOUT", "warning", "no RSI packet, with rearm: automatic",
              "look at program, pendant and RSI cable"},
    FaultKind{"E_STREAM_UNCONFIRMED", "warning", "the correction in effect is not known yet",
              "bring the arm to rest"},
    FaultKind{"E_TOOL", "warning", "the tool in use is refused", "activate another tool, or deactivate it"},
    FaultKind{"E_TOOL_DATA", "warning", "the controller has another frame for the tool",
              "write TOOL_DATA, or measure the tool again"},
    FaultKind{"E_TRACKER", "warning", "the tracker does not answer", "look at power and cable"},
};

constexpr const FaultKind& kind_of(FaultCode code) { return kFaultKinds[static_cast<std::size_t>(code)]; }
static_assert(kind_of(FaultCode::Tracker).code == "E_TRACKER" && kFaultKinds.size() == 13);

/// What an operator should know of, until it ends.
struct Fault {
  FaultCode code = FaultCode::Cell;
  std::string text;  ///< one sentence
};

}  // namespace truepose::daemon
