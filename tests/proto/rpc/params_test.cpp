#include "proto/rpc/params.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <string>
#include <string_view>

#include "proto/rpc/campaign.hpp"
#include "proto/rpc/drift.hpp"
#include "proto/rpc/events.hpp"
#include "proto/rpc/model.hpp"
#include "proto/rpc/targets.hpp"

namespace truepose::rpc {
namespace {

using testing::ElementsAre;

boost::json::object object_of(std::string_view text) {
  return boost::json::parse({text.data(), text.size()}).as_object();
}

/// What is wrong with the parameters of a request; empty: nothing.
template <Request R>
std::string complaint(std::string_view params) {
  const auto request = read_params<R>(object_of(params));
  if (request) return "";
  EXPECT_EQ(request.error().code, ErrorCode::InvalidParams);
  EXPECT_TRUE(request.error().message.starts_with(request.error().path + ": "));
  return request.error().message;
}

TEST(Params, HaveTheirUsualValuesWhereTheyAreLeftOut) {
  const auto request = read_params<TargetsCompensate>(object_of(R"({"joints":[[1,2.5],[3,4]],"tool":3})"));
  ASSERT_TRUE(request) << request.error().message;
  EXPECT_THAT(request->joints, ElementsAre(ElementsAre(1, 2.5), ElementsAre(3, 4)));
  EXPECT_EQ(request->tool, 3);
  EXPECT_EQ(request->model_id, std::nullopt);
  const auto page = read_params<ModelList>({});
  ASSERT_TRUE(page) << page.error().message;
  EXPECT_EQ(page->limit, 20);
  const auto targets = read_params<CampaignStart>(object_of(R"({"kind":"targets"})"));
  ASSERT_TRUE(targets) << targets.error().message;
  EXPECT_EQ(targets->rounds, 15);
  EXPECT_TRUE(targets->activate);
}

TEST(Params, AreWrittenWithoutWhatIsEmptyAndWhatIsUsual) {
  CampaignStart request{.rounds = {}, .tolerance_mm = {}, .poses_per_point = {}};
  EXPECT_EQ(record::to_json(request), object_of("{}"));
  request.kind = "targets";
  request.rounds = 15;
  request.activate = false;
  EXPECT_EQ(record::to_json(request), object_of(R"({"kind":"targets","rounds":15,"activate":false})"));
}

TEST(Params, SayWhatWasExpectedAndWhatWasFound) {
  EXPECT_EQ(complaint<DriftCheck>(R"({"poses":"x"})"),
            R"(params.poses: expected a whole number 1..1000, found "x")");
  EXPECT_EQ(complaint<DriftCheck>(R"({"poses":1001})"),
            "params.poses: expected a whole number 1..1000, found 1001");
  EXPECT_EQ(complaint<DriftCheck>(R"({"poses":2.5})"),
            "params.poses: expected a whole number 1..1000, found 2.5");
  EXPECT_EQ(complaint<DriftCheck>(R"({"update":1})"), "params.update: expected true or false, found 1");
  EXPECT_EQ(complaint<ModelActivate>("{}"), "params.id: is missing");
  EXPECT_EQ(complaint<TargetsCompensate>(R"({"poses":[[1,2,3,4,5,6],[3]]})"),
            "params.poses[1]: expected 6 numbers, found 1");
  EXPECT_EQ(complaint<TargetsCompensate>(R"({"joints":[]})"),
            "params.joints: expected 1..200 elements, found 0");
  EXPECT_EQ(complaint<EventsSubscribe>(R"({"topics":["cell","cel"]})"),
            "params.topics[1]: expected one of cell, campaign, measurement, stream, model, fault, log, "
            "control, found \"cel\"");
}

TEST(Params, AreRefusedWhereTheMethodDoesNotKnowThem) {
  EXPECT_EQ(complaint<DriftCheck>(R"({"pose":5})"), "params.pose: unknown parameter");
  EXPECT_EQ(complaint<ModelRollback>(R"({"id":"x"})"), "params.id: unknown parameter");
  EXPECT_EQ(complaint<CampaignStart>(R"({"kind":"tool","known":[]})"),
            "params.known: unknown parameter, renamed to 'nominal'");
}

TEST(Params, CountCharactersAsTheSchemaDoes) {
  std::string note;
  for (int i = 0; i < 500; ++i) note += "\u20ac";
  EXPECT_EQ(complaint<DriftCheck>(R"({"note":")" + note + "\"}"), "");
  EXPECT_EQ(complaint<DriftCheck>(R"({"note":")" + note + "+\"}"),
            "params.note: expected at most 500 characters, found 501");
}

TEST(Params, TakeNoEmptyTextForAnId) {
  EXPECT_EQ(complaint<ModelGet>(R"({"id":""})"), "params.id: expected 1..64 characters, found 0");
  EXPECT_EQ(complaint<ModelGet>(R"({"id":null})"), "params.id: expected a text, found null");
  EXPECT_EQ(complaint<ModelGet>(R"({"id":"d6b6d477"})"), "");
}

}  // namespace
}  // namespace truepose::rpc
