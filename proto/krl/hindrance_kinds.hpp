#pragma once

#include <array>
#include <optional>

#include "proto/krl/spot.hpp"
#include "proto/text/message.hpp"

namespace truepose::krl {

/// Why a position of a program stays as it is, in the order of their codes.
enum class HindranceKind {
  Arc,
  Argument,
  Bits,
  Changed,
  Component,
  Computed,
  Config,
  Conflict,
  Element,
  Elsewhere,
  FixedTool,
  FrameData,
  FrameMoving,
  FrameOrder,
  FrameUnset,
  FrameWritten,
  Home,
  Index,
  Large,
  Later,
  NoCorrection,
  Number,
  Reach,
  Relative,
  Start,
  System,
  Undecided,
  Unused,
};

// What several kinds share.
inline constexpr std::string_view kStreamIt =
    "stream the correction there (TP_BEGIN), or use a taught position";
inline constexpr std::string_view kGiveOneValue =
    "give it one value in its declaration, or stream the correction there (TP_BEGIN)";
inline constexpr std::string_view kUseOwnPosition = "use a position of the program if it has to be accurate";
inline constexpr std::string_view kMoveBefore = "put a motion to a known position directly before it";

inline constexpr std::array kHindranceKinds{
    MessageKind{"K_ARC", "with CA the arc ends at an angle, and at no position of the program",
                "program the arc to its end, without CA"},
    MessageKind{"K_ARGUMENT", "is handed to {0}, which may change it", kGiveOneValue},
    MessageKind{"K_BITS", "component {0} is not a plain bit pattern", "write a whole number, as 'B010' or 2"},
    MessageKind{"K_CHANGED", "{0} by the program", kGiveOneValue},
    MessageKind{"K_COMPONENT", "component {0} is missing: it keeps what the arm has then",
                "write all six components"},
    MessageKind{"K_COMPUTED", "{0} computed by the program", kStreamIt},
    MessageKind{"K_CONFIG", "is declared in $config.dat, for all programs",
                "correct all programs together (--archive)"},
    MessageKind{"K_CONFLICT", "is used {0} with another tool, base or configuration",
                "teach a position of its own for one of the motions"},
    MessageKind{"K_ELEMENT", "is an element of an array or structure",
                "use a number as index, and a whole position"},
    MessageKind{"K_ELSEWHERE", "is declared in none of the files",
                "give the file that declares it (--dat, --config-dat)"},
    MessageKind{"K_FIXED_TOOL", "the arm carries the workpiece (IPO_FRAME #TCP), which is not supported",
                "stream the correction there (TP_BEGIN)"},
    MessageKind{"K_FRAME_DATA", "{0}_DATA[{1}] is not known",
                "give a $config.dat that has it (--config-dat)"},
    MessageKind{"K_FRAME_MOVING", "BASE_DATA[{0}] is carried by an external axis",
                "stream the correction there (TP_BEGIN)"},
    MessageKind{
        "K_FRAME_ORDER",
        "{0} may be set otherwise by then, by a called routine, past a GOTO, or by a trigger or interrupt",
        "set it again directly before the motion"},
    MessageKind{"K_FRAME_UNSET", "the program does not set the {0} of this motion",
                "set it before with ${1} or BAS(#{1},n), or give --{0} x,y,z,a,b,c with --program"},
    MessageKind{"K_FRAME_WRITTEN", "{0}_DATA[{1}] is written by the program",
                "write it in $config.dat alone, or stream the correction there (TP_BEGIN)"},
    MessageKind{"K_HOME", "is a home position of the cell", kUseOwnPosition},
    MessageKind{"K_INDEX", "is also chosen by an index that the program computes",
                "use numbers as its indices, or stream the correction there (TP_BEGIN)"},
    MessageKind{"K_LARGE", "the correction would be {0:.0f} mm (limit: {1:.0f} mm)",
                "check robot file, model, tool and base"},
    MessageKind{"K_LATER", "gets its value while the program runs", kGiveOneValue},
    MessageKind{"K_NO_CORRECTION", "{0}", "{1}"},
    MessageKind{"K_NUMBER", "component {0} is not a plain number", "write a number"},
    MessageKind{"K_REACH", "{0}",
                "check robot file, tool and base, or teach it again with S and T of this arm"},
    MessageKind{"K_RELATIVE", "{0} is relative to where the arm stands", kMoveBefore},
    MessageKind{"K_START", "where the arm comes from is not known", kMoveBefore},
    MessageKind{"K_SYSTEM", "is a variable of the controller", kUseOwnPosition},
    MessageKind{"K_UNDECIDED", "{0}",
                "write S and T, or put a motion to a known position directly before it"},
    MessageKind{"K_UNUSED", "no motion goes to it", "remove it if no other program uses it"},
};

constexpr const MessageKind& kind_of(HindranceKind kind) {
  return kHindranceKinds[static_cast<std::size_t>(kind)];
}
static_assert(is_table(kHindranceKinds, "K_") && kind_of(HindranceKind::Unused).code == "K_UNUSED");

/// Why a position, or a motion, stays as it is.
struct Hindrance {
  Message message;
  std::optional<Spot> because{};  ///< the statement that does it
};

template <HindranceKind kKind, typename... Values>
Hindrance hindrance(const Values&... values) {
  return {message<kKind>(values...)};
}

}  // namespace truepose::krl
