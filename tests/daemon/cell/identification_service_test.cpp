// Stored campaigns identified again.
#include "daemon/cell/identification_service.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <set>
#include <span>
#include <utility>

#include "core/math/random.hpp"
#include "daemon/cell/campaign_archive.hpp"
#include "tests/daemon/cell_fixture.hpp"

namespace truepose::daemon {
namespace {

namespace json = boost::json;
using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::SizeIs;

std::string text_in(const json::value& value, const char* pointer) {
  return std::string{value.at_pointer(pointer).as_string()};
}

struct Identification : CellTest {
  Identification() {
    config.task.max_mm.x() = 3000;  // the example's poses are near each other
    load();
  }
  json::value identified(json::object params) {
    const Answer answer = call("campaign.identify", std::move(params));
    if (!answer) throw std::runtime_error{answer.error().message};
    return *answer;
  }
};

TEST_F(Identification, IsACampaignOfItsOwnWithAModelThatCanBeActivated) {
  const json::value made = identified({{"id", "c2"}});
  const std::string id = text_in(made, "/id"), model = text_in(made, "/model_id");
  EXPECT_EQ(made.at("points_of"), "c2");
  EXPECT_FALSE(made.at("activated").as_bool());
  EXPECT_LT(made.at("validation_after_mm").as_double(), made.at("validation_before_mm").as_double() / 10);
  EXPECT_EQ(status().at_pointer("/model/id"), "m1") << "not by itself";

  const json::value record = call("campaign.get", {{"id", id}}).value().at("campaign");
  EXPECT_EQ(record.at("state"), "done");
  EXPECT_EQ(record.at("points_of"), "c2");
  EXPECT_EQ(record.at("robot_serial"), "MOCK-0001");
  EXPECT_EQ(call("campaign.list")->at("campaigns").at(0).at("id"), json::value(id));
  EXPECT_TRUE(call("campaign.get", {{"id", "c2"}}).value().at_pointer("/campaign/points_of").is_null());
  const json::value report = call("report.get", {{"id", id}, {"points_limit", 1}}).value();
  EXPECT_EQ(report.at_pointer("/document/campaign"),
            json::value("Campaign " + id.substr(0, 8) + ", started by Anna, of the points of campaign c2"));

  const Answer activated = call("model.activate", {{"id", model}});
  ASSERT_TRUE(activated) << activated.error().message;
  EXPECT_EQ(status().at_pointer("/model/id"), json::value(model));
}

TEST_F(Identification, WithTheSameOptionsIsTheModelOfTheCampaign) {
  const std::string model = text_in(identified({{"id", "c2"}}), "/model_id");
  const auto parameters = [this](const std::string& id) {
    return call("model.get", {{"id", id}}).value().at("parameters");
  };
  EXPECT_EQ(parameters(model), parameters("m2"));
}

TEST_F(Identification, TakesOtherOptionsByTheNamesOfTheCellFile) {
  const json::value made = identified({{"id", "c2"},
                                       {"non_geometric", "auto"},
                                       {"harmonics", {1, 2, 3}},
                                       {"residual", "none"},
                                       {"loss", "tukey"},
                                       {"prior", "off"},
                                       {"correct_by_nests", false}});
  const json::value report = call("report.get", {{"id", text_in(made, "/id")}, {"points_limit", 1}}).value();
  EXPECT_EQ(report.at_pointer("/document/options/Loss"), "tukey");
  EXPECT_EQ(report.at_pointer("/document/options/Prior"), "off");
  EXPECT_EQ(report.at_pointer("/document/options/Non-geometric errors"), "auto");
  const std::string losses =
      "params.loss: expected one of outlier-rejection, squared, huber, igg3, tukey, found ";
  EXPECT_EQ(refused("campaign.identify", {{"id", "c2"}, {"loss", "lost"}}), losses + "\"lost\"");
  EXPECT_EQ(refused("campaign.identify", {{"id", "c2"}, {"loss", "screened"}}),
            losses + "\"screened\", renamed to 'outlier-rejection'");
  EXPECT_EQ(refused("campaign.identify", {{"id", "c2"}, {"deviation", "auto"}}),
            "params.deviation: unknown parameter, renamed to 'non_geometric'");
  EXPECT_THAT(refused("campaign.identify", {{"id", "c2"}, {"residual", "magic"}}), HasSubstr("\"magic\""));
  EXPECT_THAT(refused("campaign.identify", {{"id", "c2"}, {"harmonics", {0}}}),
              HasSubstr("params.harmonics[0]: expected a whole number 1..10000, found 0"));
}

TEST_F(Identification, OfACampaignThatWasAbortedDrawsPosesThatValidateAndSaysWhich) {
  play([this]() -> Wait {
    const json::object order{{"identify_poses", 30}, {"validate_poses", 10}};
    co_await ask("campaign.start", order);
    co_await pass(1min);
    for (Answer now = co_await ask("cell.status"); now->at_pointer("/campaign/done").as_int64() < 25;
         now = co_await ask("cell.status"))
      co_await pass(1s);
    co_await ask("campaign.abort");
  });
  const std::string aborted = text_in(call("campaign.get").value(), "/campaign/id");
  const json::value made = identified({{"id", aborted}});
  const auto identify = made.at("identify_poses").as_int64(), validate = made.at("validate_poses").as_int64();
  EXPECT_GE(identify + validate, 25);
  EXPECT_EQ(identify, std::lround(0.7 * static_cast<double>(identify + validate)));
  EXPECT_LT(made.at("validation_after_mm").as_double(), 0.2);

  const auto stored = read_campaign(*store, text_in(made, "/id")).value().value();
  const auto validating = std::ranges::count(stored.points, PointPurpose::Validate, &StoredPoint::purpose);
  EXPECT_EQ(validating, validate);
  EXPECT_EQ(store->points(aborted).value().size(), stored.points.size());
  EXPECT_EQ(std::ranges::count(store->points(aborted).value(), PointPurpose::Validate, &StoredPoint::purpose),
            0);
  const Answer activated = call("model.activate", {{"id", text_in(made, "/model_id")}});
  EXPECT_TRUE(activated) << activated.error().message;
}

TEST_F(Identification, IsRefusedWhereThePointsAreTooFewOrOfNoUse) {
  EXPECT_EQ(refused("campaign.identify", {{"id", "none"}}), "no such campaign");
  CampaignRecord record;
  record.id = "few";
  record.state = "failed";
  ASSERT_TRUE(store->begin_campaign(record));
  EXPECT_THAT(refused("campaign.identify", {{"id", "few"}}),
              HasSubstr("campaign few yields no model: of the poses to identify from, 0 are too few"));
  const std::vector<StoredPoint> points = store->points("c1").value();
  for (std::size_t i = 0; i < 5; ++i) ASSERT_TRUE(store->add_point("few", points[i]));
  EXPECT_THAT(refused("campaign.identify", {{"id", "few"}}), HasSubstr("5 are too few"));
  EXPECT_THAT(store->campaigns().value(), SizeIs(3)) << "nothing is kept of it";
}

TEST_F(Identification, OfAnIdentificationIsOfThePointsThatThatWasMadeOf) {
  const std::string first = text_in(identified({{"id", "c2"}, {"split", 0.6}}), "/id");
  const json::value second = identified({{"id", first}});
  EXPECT_EQ(second.at("points_of"), "c2");
  EXPECT_EQ(second.at("identify_poses"), identified({{"id", "c2"}}).at("identify_poses"));
}

TEST_F(Identification, ActivatesWhereThatIsAskedForAndNothingContradicts) {
  const json::value made = identified({{"id", "c2"}, {"activate", true}});
  EXPECT_TRUE(made.at("activated").as_bool()) << made.at("reason");
  EXPECT_EQ(status().at_pointer("/model/id"), made.at("model_id"));
}

TEST_F(Identification, AMeasurementFileOfACampaignIsWhatWasMeasured) {
  const Answer part = call("campaign.export", {{"id", "c2"}});
  ASSERT_TRUE(part);
  const std::string csv = text_in(*part, "/data");
  const auto points = store->points("c2").value();
  const auto used = std::ranges::count_if(points, [](const StoredPoint& point) {
    return point.purpose == PointPurpose::Identify || point.purpose == PointPurpose::Validate;
  });
  EXPECT_EQ(std::ranges::count(csv, '\n'), used + 1);
  EXPECT_EQ(
      call("campaign.export", {{"id", "c2"}, {"offset", static_cast<std::int64_t>(csv.size())}})->at("data"),
      "");
  EXPECT_EQ(refused("campaign.export", {{"id", "none"}}), "no such campaign");
}

TEST_F(Identification, ABackupIsReadPartByPart) {
  config.store = file;
  const Answer made = call("store.backup");
  ASSERT_TRUE(made) << made.error().message;
  const std::string id = text_in(*made, "/id");
  EXPECT_EQ(text_in(*made, "/file"), file.string() + ".backup");
  const Answer part = call("store.get_backup", {{"id", id}});
  ASSERT_TRUE(part);
  EXPECT_TRUE(text_in(*part, "/data").starts_with("U1FMaXRl")) << "SQLite";
  EXPECT_THAT(refused("store.get_backup", {{"id", "another"}}), HasSubstr("no such backup"));
  ASSERT_TRUE(call("store.backup"));
  EXPECT_THAT(refused("store.get_backup", {{"id", id}}), HasSubstr("another was made since"));
}

TEST_F(Identification, BackupsHaveTheSameIdsFromTheSameRandomNumbers) {
  config.store = file;
  const auto ids_from = [this](std::uint64_t seed) {
    const auto random = [numbers = std::make_shared<Random>(seed)](std::span<unsigned char> bytes) {
      for (unsigned char& byte : bytes) byte = static_cast<unsigned char>(numbers->next());
    };
    DaemonCell life{{io.get_executor(),
                     config,
                     robot,
                     tracker,
                     clock,
                     *stream,
                     *store,
                     store_thread,
                     compute_thread,
                     events,
                     recorder,
                     recorder_thread,
                     wall_clock,
                     {},
                     random}};
    const Answer one = finish(life.call("store.backup", {}, kOperator));
    const Answer other = finish(life.call("store.backup", {}, kOperator));
    return std::pair{text_in(one.value(), "/id"), text_in(other.value(), "/id")};
  };
  const auto ids = ids_from(1);
  EXPECT_NE(ids.first, ids.second);
  EXPECT_EQ(ids_from(1), ids);
  EXPECT_NE(ids_from(2), ids);
}

}  // namespace
}  // namespace truepose::daemon
