#include "tools/sim/controller/rsi_flow.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace truepose::sim {
namespace {

FlowSources sources() {
  FlowSources sources;
  sources.sen_pint = [](int) { return 0; };
  sources.in = [](int index) { return index == 4 || index == 17 || index == 19; };
  sources.axes_deg = {10, 20, 30, 40, 50, 60};
  return sources;
}

/// truepose's flow with more objects, and inputs 6, 7, .. of ETHERNET led by the first output of each.
rsi::Context with(std::vector<rsi::ContextObject> more) {
  rsi::Context context = rsi::truepose_context({});
  auto& ethernet = *std::ranges::find(context.objects, "ETHERNET", &rsi::ContextObject::type);
  int input = 5;
  for (const rsi::ContextObject& object : more) {
    if (object.inputs.empty()) ethernet.inputs[++input] = {object.id, 1};
  }
  std::ranges::move(more, std::back_inserter(context.objects));
  return context;
}

TEST(RsiFlow, SendsInputsOutputsAxesAndSources) {
  const auto flow =
      RsiFlow::of(with({{.type = "DIGIN", .id = "D1", .values = {{"Index", "4"}}},
                        {.type = "DIGIN", .id = "D2", .values = {{"Index", "2"}, {"DataType", "2"}}},
                        {.type = "AXISACT", .id = "A"},
                        {.type = "SOURCE", .id = "S", .values = {{"Offset", "7"}}},
                        {.type = "GEARTORQUE", .id = "G"},
                        {.type = "MONITOR", .id = "M", .inputs = {{1, {"A", 2}}}}}));
  ASSERT_TRUE(flow) << flow.error();
  const ChannelValues sent = flow->sent(sources());
  EXPECT_EQ(sent.at(6), 1);
  EXPECT_EQ(sent.at(7), 5) << "$IN[17] to $IN[24] of byte 2";
  EXPECT_EQ(sent.at(8), 10);
  EXPECT_EQ(sent.at(9), 7);
  EXPECT_EQ(sent.at(10), 0);
}

TEST(RsiFlow, LeadsCorrectionsThroughALimitAndSetsOutputs) {
  rsi::Context context = with(
      {{.type = "LIMIT",
        .id = "L",
        .inputs = {{1, {"ETHERNET1", 1}}},
        .values = {{"LowerLimit", "-0.5"}, {"UpperLimit", "0.5"}}},
       {.type = "MAP2DIGOUT", .id = "O", .inputs = {{1, {"ETHERNET1", 9}}}, .values = {{"Index", "3"}}}});
  std::ranges::find(context.objects, "AXISCORR", &rsi::ContextObject::type)->inputs[1] = {"L", 1};
  const auto flow = RsiFlow::of(context);
  ASSERT_TRUE(flow) << flow.error();
  const FlowEffects effects = flow->effects(sources(), {{1, 2.0}, {2, 2.0}, {9, 1.0}});
  EXPECT_EQ(effects.correction_deg[0], 0.5);
  EXPECT_EQ(effects.correction_deg[1], 2);
  EXPECT_EQ(effects.outputs, (std::map<int, bool>{{3, true}}));
}

TEST(RsiFlow, SetsAByteOfOutputsAndRealsAsKukasExampleDoes) {
  const auto flow = RsiFlow::of(with(
      {{.type = "MAP2DIGOUT",
        .id = "O",
        .inputs = {{1, {"ETHERNET1", 9}}},
        .values = {{"Index", "4"}, {"DataType", "1"}}},
       {.type = "MAP2SEN_PREA", .id = "R", .inputs = {{1, {"ETHERNET1", 10}}}, .values = {{"Index", "2"}}}}));
  ASSERT_TRUE(flow) << flow.error();
  const FlowEffects effects = flow->effects(sources(), {{9, 125.0}, {10, -0.25}});
  EXPECT_EQ(
      effects.outputs,
      (std::map<int, bool>{
          {33, true}, {34, false}, {35, true}, {36, true}, {37, true}, {38, true}, {39, true}, {40, false}}))
      << "125 in $OUT[33] to $OUT[40]";
  EXPECT_EQ(effects.sen_prea, (std::map<int, double>{{2, -0.25}}));
}

TEST(RsiFlow, LeadsAConstantToEthernetAndCorrectionsAndAnalogOutputs) {
  rsi::Context context =
      with({{.type = "CONSTANT", .id = "C", .values = {{"Value", "0.75"}}},
            {.type = "CONSTANT", .id = "Zero"},
            {.type = "MAP2ANOUT", .id = "O1", .inputs = {{1, {"ETHERNET1", 9}}}, .values = {{"Index", "3"}}},
            {.type = "MAP2ANOUT", .id = "O2", .inputs = {{1, {"C", 1}}}}});
  std::ranges::find(context.objects, "AXISCORR", &rsi::ContextObject::type)->inputs[2] = {"C", 1};
  const auto flow = RsiFlow::of(context);
  ASSERT_TRUE(flow) << flow.error();
  const ChannelValues sent = flow->sent(sources());
  EXPECT_EQ(sent.at(6), 0.75);
  EXPECT_EQ(sent.at(7), 0) << "what it is without a value";
  const FlowEffects effects = flow->effects(sources(), {{9, -0.25}});
  EXPECT_EQ(effects.correction_deg[1], 0.75);
  EXPECT_EQ(effects.analog, (std::map<int, double>{{1, 0.75}, {3, -0.25}})) << "$ANOUT[1] and $ANOUT[3]";
}

TEST(RsiFlow, AddsCorrectionsUpToTheLimitsWhereTheyAreRelative) {
  const auto flow = RsiFlow::of(with({}));
  ASSERT_TRUE(flow) << flow.error();
  FlowEffects total;
  for (int cycle = 1; cycle <= 3; ++cycle) {
    total = flow->effects(sources(), {{2, 0.4}}, total);
    EXPECT_NEAR(total.correction_deg[1], 0.4 * cycle, 1e-12);
  }
  for (int cycle = 0; cycle < 100; ++cycle) total = flow->effects(sources(), {{2, 0.4}}, total);
  EXPECT_TRUE(total.clamped);
  const double limit_deg = total.correction_deg[1];
  EXPECT_EQ(flow->effects(sources(), {{2, 0.4}}, total).correction_deg[1], limit_deg);
  EXPECT_EQ(flow->effects(sources(), {{2, 0.4}}).correction_deg[1], 0.4) << "absolute";
}

TEST(RsiFlow, SetsParametersByNamesInAnyLetterCase) {
  rsi::Context context = with({});
  const std::string id = std::ranges::find(context.objects, "AXISCORR", &rsi::ContextObject::type)->id;
  set_parameter(context, {id, "lowerlima2", -0.25});
  EXPECT_EQ(value_of(context, {id, "LOWERLIMA2"}), -0.25);
  EXPECT_EQ(value_of(context, {id, "LowerLimA7"}), std::nullopt);
  EXPECT_EQ(value_of(context, {"nothing", "LowerLimA1"}), std::nullopt);
  EXPECT_EQ(value_of(context, {"POSCORRMON", "MaxTrans"}), 6) << "the controller's own, which no file has";
  const auto flow = RsiFlow::of(context);
  ASSERT_TRUE(flow) << flow.error();
  EXPECT_EQ(flow->effects(sources(), {{2, -1.0}}).correction_deg[1], -0.25);
}

TEST(RsiFlow, RunsWithAMonitorOfWhatItDoesNotSimulateAsKukasSdkHasOne) {
  const auto flow =
      RsiFlow::of(with({{.type = "MONITOR", .id = "Monitor_1", .inputs = {{1, {"AXISCORRMON1", 1}}}}}));
  EXPECT_TRUE(flow) << flow.error();
}

TEST(RsiFlow, RefusesByNameWhatIsNotSimulated) {
  const auto error = [](std::vector<rsi::ContextObject> more) {
    const auto flow = RsiFlow::of(with(std::move(more)));
    return flow ? "" : flow.error();
  };
  EXPECT_EQ(error({{.type = "PID", .id = "P"}}), "P: PID is not simulated");
  EXPECT_EQ(error({{.type = "AXISCORREXT", .id = "E"}}), "E: the simulated arm has no external axes");
  EXPECT_EQ(error({{.type = "AXISCORR", .id = "B"}}), "ETHERNET1: a wire from B to here is not simulated");
  EXPECT_EQ(error({{.type = "LIMIT", .id = "L", .inputs = {{1, {"L", 1}}}}}),
            "L: a signal leads from it back to it (\"Circular linking\")");
}

}  // namespace
}  // namespace truepose::sim
