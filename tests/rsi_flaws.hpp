#pragma once

#include <functional>
#include <string>
#include <vector>

#include "proto/rsi/context.hpp"
#include "proto/rsi/lint_kinds.hpp"

/// For each kind of finding in the RSI files of a controller, how files of ours come to have it.
namespace truepose::rsi {

inline ContextObject& object_of(Context& context, const std::string& type) {
  return const_cast<ContextObject&>(*context.of_type(type));
}

struct ContextFlaw {
  LintKind kind;
  const char* found;  ///< part of the sentences
  std::function<void(Context&)> make;
};

inline std::vector<ContextFlaw> context_flaws() {
  const auto erased = [](const char* type) {
    return [type](Context& c) { std::erase_if(c.objects, [&](const auto& o) { return o.type == type; }); };
  };
  const auto set = [](const char* type, const char* parameter, const char* value) {
    return [=](Context& c) { object_of(c, type).values[parameter] = value; };
  };
  return {
      {LintKind::NoEthernet, "the context has no ETHERNET object: nothing is exchanged",
       [](Context& c) {
         std::erase_if(c.objects, [](const auto& o) { return o.type == "ETHERNET"; });
         for (ContextObject& left : c.objects) left.inputs.clear();
       }},
      {LintKind::NoAxisCorr, "no AXISCORR object", erased("AXISCORR")},
      {LintKind::StopMissing, "no STOP object is led by Stop", erased("STOP")},
      {LintKind::Gain, "no MAP2SEN_PINT object writes Tp.Gain", erased("MAP2SEN_PINT")},
      {LintKind::ConfigFile,
       "loads other.xml, not truepose_rsi_ethernet.xml. Set its ConfigFile to truepose_rsi_ethernet.xml.",
       set("ETHERNET", "ConfigFile", "other.xml")},
      {LintKind::Precision,
       "ETHERNET1: Precision 1 rounds the axes to 0.1 deg (limit: Precision 4). Set Precision of",
       set("ETHERNET", "Precision", "1")},
      {LintKind::Timeout, "Timeout is 10 cycles (0.04 s), but stream.timeout_cycles is 100",
       set("ETHERNET", "Timeout", "10")},
      {LintKind::Clamp, "AXISCORR1: A2 is clamped silently to -1 .. 3 deg (stream.max_total_deg: 3 deg)",
       set("AXISCORR", "LowerLimA2", "-1")},
      {LintKind::Ceiling, "AXISCORRMON1: RSI stops at 3 deg of A6 (stream.max_total_deg: 3 deg). Set MaxA1",
       set("AXISCORRMON", "MaxA6", "3")},
      {LintKind::StopMode,
       "STOP1: Mode is 1: the Stop bit does not just leave RSI_MOVECORR. Set Mode to 4 (ExitMoveCorr).",
       set("STOP", "Mode", "1")},
      {LintKind::Gain, "no MAP2SEN_PINT object writes Tp.Gain", set("MAP2SEN_PINT", "Index", "1")},
      {LintKind::Input, "input 1, sent as Tp.Ask, is not led by $SEN_PINT[1]", set("SEN_PINT", "Index", "3")},
      {LintKind::Input, "input 2, sent as Tp.Pro, is not led by $PRO_STATE", set("STATUS", "Type", "1")},
      {LintKind::Input, "input 3, sent as Tp.Mode, is not led by the operating mode",
       [](Context& c) { c.objects.at(2).values["Type"] = "2"; }},
      {LintKind::Input, "input 4, sent as Tp.Ov, is not led by $OV_PRO",
       [](Context& c) { object_of(c, "ETHERNET").inputs.at(4).object = "STATUS1"; }},
      {LintKind::Input, "input 5, sent as Tp.Cell, is not led by $SEN_PINT[3]",
       [](Context& c) { object_of(c, "ETHERNET").inputs.at(5).object = "SEN_PINT1"; }},
      {LintKind::Input, "input 5, sent as Tp.Cell, is not led by $SEN_PINT[3]",
       [](Context& c) { object_of(c, "ETHERNET").inputs.erase(5); }},
      {LintKind::Circle,
       "input 6 comes from AXISCORR1, which ETHERNET1 itself leads: the controller refuses such a circle",
       [](Context& c) {
         object_of(c, "ETHERNET").inputs[6] = {"AXISCORR1", 1};
       }},
      {LintKind::Circle, "input 6 comes from LIMIT1, which ETHERNET1 itself leads",
       [](Context& c) {
         c.objects.push_back({.type = "LIMIT", .id = "LIMIT1", .inputs = {{1, {"ETHERNET1", 9}}}});
         object_of(c, "ETHERNET").inputs[6] = {"LIMIT1", 1};
       }},
      {LintKind::AxisTwice, "AXISCORR1 and AXISCORR2 both correct A3: the corrections may add up",
       [](Context& c) {
         c.objects.push_back({.type = "AXISCORR", .id = "AXISCORR2", .inputs = {{3, {"ETHERNET1", 3}}}});
       }},
      {LintKind::ExternalAxis,
       "AXISCORREXT1: CorrE1 is led by AK.A2, which is to move an axis of the arm alone",
       [](Context& c) {
         c.objects.push_back(
             {.type = "AXISCORREXT", .id = "AXISCORREXT1", .inputs = {{1, {"ETHERNET1", 2}}}});
       }},
      {LintKind::AxisUnwired, "nothing leads to CorrA4, which AK.A4 is to move",
       [](Context& c) { object_of(c, "AXISCORR").inputs.erase(4); }},
      {LintKind::AxisWire,
       "CorrA1 is led by output 2 of ETHERNET1, but AK.A1 comes out of output 1 of ETHERNET1",
       [](Context& c) { object_of(c, "AXISCORR").inputs[1].number = 2; }},
      {LintKind::PoseCorrection, "POSCORR1: moves the TCP along",
       [](Context& c) {
         c.objects.push_back({.type = "POSCORR", .id = "POSCORR1", .inputs = {{1, {"ETHERNET1", 1}}}});
       }},
  };
}

/// Of the ethernet configuration: its first `from` is `to`.
struct EthernetFlaw {
  LintKind kind;
  const char* found;
  std::string from, to;
};

inline std::vector<EthernetFlaw> ethernet_flaws() {
  // Before the elements of RECEIVE.
  const std::string first = "<ELEMENT TAG=\"AK.A1\"";
  const auto element = [](const std::string& tag) {
    return "<ELEMENT TAG=\"" + tag + R"(" TYPE="DOUBLE" INDX="1" HOLDON="1"/>)";
  };
  std::string of_axes, of_pose;
  for (const std::string axis : {"A1", "A2", "A3", "A4", "A5", "A6"}) of_axes += element("BK." + axis);
  for (const std::string axis : {"X", "Y", "Z", "A", "B", "C"}) of_pose += element("RKorr." + axis);
  return {
      {LintKind::HoldOn, "RECEIVE element AK.A1 has HOLDON 0", R"(HOLDON="1")", R"(HOLDON="0")"},
      {LintKind::OnlySend, "ONLYSEND", "<ONLYSEND>FALSE", "<ONLYSEND>TRUE"},
      {LintKind::NoCorrection, "RECEIVE has no axis correction", "AK.A3", "AK.C3"},
      {LintKind::Generator, "DEF_Tech.T1", "DEF_RSol", "DEF_Tech.T1"},
      {LintKind::Aspos, "SEND has no DEF_ASPos", "DEF_ASPos", "DEF_ESPos"},
      {LintKind::Aipos, "SEND has no DEF_AIPos", "DEF_AIPos", "DEF_EIPos"},
      {LintKind::StopElement, "RECEIVE has no BOOL element Stop", "\"Stop\"", "\"DiO\""},
      {LintKind::NeverSent, "RECEIVE element DiO", "\"Stop\"", "\"DiO\""},
      {LintKind::Rist, "SEND has no DEF_RIst", "DEF_RIst", "DEF_RSol2"},
      {LintKind::Delay, "SEND has no DEF_Delay", "DEF_Delay", "DEF_Delay2"},
      {LintKind::SeveralCorrections, "RECEIVE has several elements with A1..A6: BK is taken", first,
       of_axes + first},
      {LintKind::Cartesian, "RECEIVE has a Cartesian correction, RKorr", first, of_pose + first},
  };
}

}  // namespace truepose::rsi
