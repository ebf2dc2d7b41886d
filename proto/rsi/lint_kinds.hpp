#pragma once

#include <array>

#include "proto/text/message.hpp"

namespace truepose::rsi {

/// What may be wrong with the RSI files of a controller, in the order of their codes.
enum class LintKind {
  Address,
  Aipos,
  Aspos,
  AxisTwice,
  AxisUnwired,
  AxisWire,
  Cartesian,
  Ceiling,
  Circle,
  Clamp,
  ConfigFile,
  Delay,
  ExternalAxis,
  Gain,
  Generator,
  HoldOn,
  Input,
  NeverSent,
  NoAxisCorr,
  NoCorrection,
  NoEthernet,
  OnlySend,
  PoseCorrection,
  Precision,
  Rist,
  SeveralCorrections,
  StopElement,
  StopMissing,
  StopMode,
  Timeout,
};

inline constexpr std::array kLintKinds{
    MessageKind{"L_ADDRESS", "the controller sends to {0}:{1} (IP_NUMBER and PORT), but stream.listen is {2}",
                "make them the same"},
    MessageKind{"L_AIPOS", "SEND has no DEF_AIPos: it alone shows if the arm follows the correction",
                "add DEF_AIPos"},
    MessageKind{"L_ASPOS",
                "SEND has no DEF_ASPos: the commanded axes are AIPos less the correction in effect",
                "add DEF_ASPos"},
    MessageKind{"L_AXIS_TWICE", "{0} and {1} both correct {2}: the corrections may add up",
                "remove one of them"},
    MessageKind{"L_AXIS_UNWIRED", "nothing leads to Corr{0}, which {1} is to move", "wire {1} to it"},
    MessageKind{"L_AXIS_WIRE", "Corr{0} is led by output {1} of {2}, but {3} comes out of output {4} of {5}",
                "wire {3} to Corr{0}"},
    MessageKind{"L_CARTESIAN",
                "RECEIVE has a Cartesian correction, {0}: truepose corrects axes alone and never sends it",
                "remove it, or keep its start value at 0"},
    MessageKind{"L_CEILING", "RSI stops at {1:g} deg of {0} (stream.max_total_deg: {2:g} deg)",
                "set MaxA1 to MaxA6 of AXISCORRMON above stream.max_total_deg"},
    MessageKind{"L_CIRCLE",
                "input {0} comes from {1}, which {2} itself leads: the controller refuses such a circle "
                "(\"Circular linking\")",
                "remove the wire"},
    MessageKind{"L_CLAMP", "{0} is clamped silently to {1:g} .. {2:g} deg (stream.max_total_deg: {3:g} deg)",
                "widen LowerLim and UpperLim of the axes, or lower stream.max_total_deg"},
    MessageKind{"L_CONFIG_FILE", "loads {0}, not {1}", "set its ConfigFile to {1}"},
    MessageKind{"L_DELAY", "SEND has no DEF_Delay: it alone shows which replies the controller takes",
                "add DEF_Delay"},
    MessageKind{"L_EXTERNAL_AXIS", "CorrE{0} is led by {1}, which is to move an axis of the arm alone",
                "remove the wire"},
    MessageKind{"L_GAIN", "no MAP2SEN_PINT object writes {0} to $SEN_PINT[2]: TP_BEGIN() would wait for ever",
                "add one with Index 2 and wire {0} to it"},
    MessageKind{"L_GENERATOR", "DEF_Tech.T1 is listed, but RSI needs technology generator 1 itself (RSIBad)",
                "remove DEF_Tech.T1"},
    MessageKind{"L_HOLDON",
                "RECEIVE element {0} has HOLDON 0: one lost reply makes the correction jump to zero",
                "set its HOLDON to 1"},
    MessageKind{"L_INPUT", "input {0}, sent as {1}, is not led by {2}", "wire {2} to it"},
    MessageKind{"L_NEVER_SENT", "RECEIVE element {0} is never sent by truepose and keeps its start value",
                "remove it, or check that its start value does no harm"},
    MessageKind{"L_NO_AXISCORR", "the context has no AXISCORR object: no correction reaches an axis",
                "add it, and wire the correction of each axis to it"},
    MessageKind{"L_NO_CORRECTION", "RECEIVE has no axis correction: an element with A1..A6, all DOUBLE",
                "add it, and wire it to AXISCORR"},
    MessageKind{"L_NO_ETHERNET", "the context has no ETHERNET object: nothing is exchanged with the PC",
                "add it, or load the context of truepose kuka write"},
    MessageKind{"L_ONLYSEND", "ONLYSEND is TRUE: the controller takes no reply and no correction",
                "set it to FALSE"},
    MessageKind{
        "L_POSCORR",
        "moves the TCP along {0} by what {1} brings ({2}; POSCORRMON stops RSI at {3:g} mm or {4:g} deg), "
        "but truepose sends nothing for it",
        "correct axes by AXISCORR, and remove its wires"},
    MessageKind{"L_PRECISION", "Precision {0:g} rounds the axes to {1:g} deg (limit: Precision {2:g})",
                "set Precision of the ETHERNET object in the RSI context to {2:g}"},
    MessageKind{"L_RIST", "SEND has no DEF_RIst: it alone shows if this is the arm of robot.file",
                "add DEF_RIst"},
    MessageKind{"L_SEVERAL_CORRECTIONS",
                "RECEIVE has several elements with A1..A6: {0} is taken as the axis correction",
                "remove the others"},
    MessageKind{"L_STOP_ELEMENT",
                "RECEIVE has no BOOL element Stop: only an RSI timeout or the pendant can end a stream",
                "add it, and wire it to a STOP object"},
    MessageKind{"L_STOP_MISSING", "no STOP object is led by {0}: the PC cannot leave RSI_MOVECORR",
                "add one with Mode ExitMoveCorr and wire {0} to it"},
    MessageKind{"L_STOP_MODE", "Mode is {0:g}: the Stop bit does not just leave RSI_MOVECORR",
                "set Mode to {1} (ExitMoveCorr)"},
    MessageKind{"L_TIMEOUT", "Timeout is {0:g} cycles ({1:g} s), but stream.timeout_cycles is {2}",
                "make them the same"},
};

inline constexpr double kLeastPrecision = 4;  ///< of ETHERNET: AIPos and ASPos to 0.0001 deg

constexpr const MessageKind& kind_of(LintKind kind) { return kLintKinds[static_cast<std::size_t>(kind)]; }
static_assert(is_table(kLintKinds, "L_") && kind_of(LintKind::Timeout).code == "L_TIMEOUT");

}  // namespace truepose::rsi
