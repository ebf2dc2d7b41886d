#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <fstream>
#include <iterator>

#include "proto/record/calibration_document.hpp"
#include "proto/record/drift_document.hpp"
#include "proto/record/frame_document.hpp"
#include "proto/record/iso9283_document.hpp"
#include "proto/record/json_io.hpp"
#include "tests/members.hpp"
#include "tests/model_members.hpp"

namespace truepose {

using namespace record;

template <>
inline constexpr int kMembers<CalibrationDocument> = 47;
template <>
inline constexpr int kMembers<Run> = 8;
template <>
inline constexpr int kMembers<TrueLink> = 5;
template <>
inline constexpr int kMembers<Truth> = 3;
template <>
inline constexpr int kMembers<Thermal> = 8;
template <>
inline constexpr int kMembers<Point> = 15;
template <>
inline constexpr int kMembers<Rejected> = 8;
template <>
inline constexpr int kMembers<Station> = 4;
template <>
inline constexpr int kMembers<Observability> = 3;
template <>
inline constexpr int kMembers<ObservabilityIndices> = 5;
template <>
inline constexpr int kMembers<UsedPrior> = 2;
template <>
inline constexpr int kMembers<PriorScale> = 4;
template <>
inline constexpr int kMembers<Iterations> = 2;
template <>
inline constexpr int kMembers<StageSpread> = 3;
template <>
inline constexpr int kMembers<Spread> = 5;
template <>
inline constexpr int kMembers<Extent> = 2;
template <>
inline constexpr int kMembers<Conditions> = 7;
template <>
inline constexpr int kMembers<SkippedPose> = 3;
template <>
inline constexpr int kMembers<Interruption> = 3;
template <>
inline constexpr int kMembers<Remeasured> = 3;
template <>
inline constexpr int kMembers<Stream> = 8;
template <>
inline constexpr int kMembers<Stream::Turnaround> = 4;
template <>
inline constexpr int kMembers<Production> = 2;
template <>
inline constexpr int kMembers<ProductionPath> = 3;
template <>
inline constexpr int kMembers<PathSample> = 7;
template <>
inline constexpr int kMembers<PathAccuracy> = 4;
template <>
inline constexpr int kMembers<DriveLag> = 2;
template <>
inline constexpr int kMembers<AxisLag> = 3;
template <>
inline constexpr int kMembers<ErrorComparison> = 3;
template <>
inline constexpr int kMembers<ErrorLengths> = 3;
template <>
inline constexpr int kMembers<AxisStatistics> = 3;
template <>
inline constexpr int kMembers<ErrorStatistics> = 9;
template <>
inline constexpr int kMembers<StageErrors> = 6;
template <>
inline constexpr int kMembers<TurnErrors> = 3;
template <>
inline constexpr int kMembers<TurnStatistics> = 3;
template <>
inline constexpr int kMembers<TurnedTarget> = 4;
template <>
inline constexpr int kMembers<MountedTarget> = 3;
template <>
inline constexpr int kMembers<DeviationGain> = 3;
template <>
inline constexpr int kMembers<DeviationChoice> = 6;
template <>
inline constexpr int kMembers<CrossValidation> = 6;
template <>
inline constexpr int kMembers<FieldChoice> = 4;
template <>
inline constexpr int kMembers<Transfer> = 5;
template <>
inline constexpr int kMembers<UncertaintyMap> = 4;
template <>
inline constexpr int kMembers<Sweep> = 4;
template <>
inline constexpr int kMembers<Arm> = 6;
template <>
inline constexpr int kMembers<ArmJoint> = 2;
template <>
inline constexpr int kMembers<ArmJoint::Mass> = 1;
template <>
inline constexpr int kMembers<DriftDocument> = 13;
template <>
inline constexpr int kMembers<DriftDocument::Error> = 3;
template <>
inline constexpr int kMembers<DriftDocument::Cause> = 9;
template <>
inline constexpr int kMembers<ModelUpdate> = 8;
template <>
inline constexpr int kMembers<FrameDocument> = 14;
template <>
inline constexpr int kMembers<FrameDocument::Reading> = 4;
template <>
inline constexpr int kMembers<FrameDocument::Shift> = 3;
template <>
inline constexpr int kMembers<FrameDocument::Point> = 3;
template <>
inline constexpr int kMembers<Iso9283Document> = 8;
template <>
inline constexpr int kMembers<Iso9283Document::Set> = 5;
template <>
inline constexpr int kMembers<Iso9283Document::Variation> = 4;
template <>
inline constexpr int kMembers<Iso9283Document::Drift> = 4;
template <>
inline constexpr int kMembers<SeriesCharacteristics> = 2;
template <>
inline constexpr int kMembers<PoseAccuracy> = 3;
template <>
inline constexpr int kMembers<PoseRepeatability> = 4;
template <>
inline constexpr int kMembers<AccuracyVariation> = 2;
template <>
inline constexpr int kMembers<PoseDrift> = 5;

namespace record {
namespace {

namespace json = boost::json;
using testing::HasSubstr;

/// A document with every member set, as far as one may have it.
CalibrationDocument full_document() {
  CalibrationDocument x;
  Filler{}(x);
  // What a document does not say.
  x.non_geometric->terms.clear();
  x.method = Method::TwoStage;  // the only one
  x.field->tried = {
      .rms = x.field->tried.rms, .standard_error = x.field->tried.standard_error, .on_all = nullptr};
  x.non_geometric->likely = {};
  x.prior->scale.deviation = PriorScale{}.deviation;
  x.prior->scale.reflector_mm = PriorScale{}.reflector_mm;
  for (ArmJoint& each : x.arm->joints) {
    each.joint.acceleration = 0;
    each.joint.type = JointType::Revolute;  // as coupled ones are
    each.joint.sign = -1;
  }
  x.arm->coupling = {{.joint = 1, .to = 0, .factor = 0.25}};
  std::vector<StageErrors*> all_stages{&x.identify, &*x.validate};
  for (Station& station : x.stations) {
    all_stages.push_back(&station.identify);
    all_stages.push_back(&*station.validate);
  }
  for (StageErrors* stages : all_stages)
    stages->before.count = stages->geometric.count = stages->after.count = stages->points;
  for (Run& run : x.splits)
    for (StageErrors* stages : {&run.identify, &run.validate})
      stages->before.count = stages->geometric.count = stages->after.count = stages->points;
  x.remeasured->count = x.validate->points;
  for (UncertaintyMap& map : x.prediction_uncertainty->maps) {
    map.x.joint = map.y.joint = 1;
    map.x.count = map.y.count = 2;
  }
  x.spread->count = 3;
  return x;
}

std::string error_of(json::object document) { return read_calibration_document(document).error(); }

TEST(CalibrationDocumentReader, ReadsBackEveryMemberThatIsWritten) {
  const CalibrationDocument x = full_document();
  const auto read = read_calibration_document(calibration_document(x));
  ASSERT_TRUE(read) << read.error();
  EXPECT_TRUE(same(*read, x));
}

TEST(CalibrationDocumentReader, ReadsDocumentsThatHaveNoMoreThanIsNeeded) {
  json::object document = calibration_document(full_document());
  const std::vector<std::string> needed{"method",   "converged", "iterations", "elapsed_s",
                                        "identify", "rank",      "condition",  "parameters"};
  std::vector<std::string> all;
  for (const auto& [key, value] : document) all.emplace_back(key);
  for (const std::string& key : all) {
    if (std::ranges::find(needed, key) == needed.end()) document.erase(key);
  }
  for (json::value& parameter : document["parameters"].as_array()) parameter.as_object().erase("data_share");
  const auto read = read_calibration_document(document);
  ASSERT_TRUE(read) << read.error();
  EXPECT_TRUE(read->points.empty());
  EXPECT_EQ(read->parameters[0].data_share, 1);
  for (const std::string& key : needed) {
    json::object without = document;
    without.erase(key);
    EXPECT_EQ(error_of(without), "missing key '" + key + "'");
  }
}

TEST(CalibrationDocumentReader, NamesTheMemberThatIsWrongAndWhatItFound) {
  const json::object document = calibration_document(full_document());
  const auto with = [&](const char* pointer, const json::value& value) {
    json::value changed = document;
    changed.at_pointer(pointer) = value;
    return error_of(changed.as_object());
  };
  EXPECT_EQ(with("/points/1/pose", 0), "points[1].pose: expected a whole number of 1 or more, found 0");
  EXPECT_EQ(with("/points/1/pose", 1.5), "points[1].pose: expected a whole number of 1 or more, found 1.5");
  EXPECT_EQ(with("/points/0/set", "both"),
            "points[0].set: expected one of identify, validate, found \"both\"");
  EXPECT_EQ(with("/points/0/before", json::array{1, 2}), "points[0].before: expected 3 numbers, found 2");
  EXPECT_EQ(with("/identify/after/x/rms", "a"),
            "identify.after.x.rms: expected a number of 0.0 or more, found \"a\"");
  EXPECT_EQ(with("/parameters/0/data_share", 2),
            "parameters[0].data_share: expected a number 0.0..1.0, found 2");
  EXPECT_EQ(with("/rank", nullptr), "rank: expected a whole number of 0 or more, found null");
  EXPECT_EQ(with("/smr", 3), "smr: expected an object, found 3");
  EXPECT_EQ(with("/arm/joints/1/sign", 0), "arm.joints[1].sign: expected -1 or 1, found 0");
  EXPECT_EQ(with("/prediction_uncertainty/maps/0/sigma_mm", json::array{}),
            "prediction_uncertainty.maps[0].sigma_mm: expected a list for each y");
  EXPECT_THAT(with("/residual/chosen", "gp"), HasSubstr("residual.chosen: expected true or false"));
}

TEST(DocumentReaders, RefuseAnOldMemberWithItsNewName) {
  struct Old {
    const char *place, *key, *new_key;
  };
  const auto with = [](json::value document, const Old& old) {
    document.at_pointer(old.place).as_object()[old.key] = 0;
    return document.as_object();
  };
  const auto refusal = [](const Old& old) {
    return "unknown key '" + std::string{old.key} + "', renamed to '" + old.new_key + "'";
  };
  for (const Old& old :
       {Old{"", "deviation", "non_geometric"}, Old{"", "far_validation", "validation_outliers"},
        Old{"", "transfer", "prediction_uncertainty"}, Old{"/observability", "unknown", "not_identifiable"},
        Old{"/observability", "weak", "weakly_identifiable"},
        Old{"/thermal", "growth_ppm_per_k", "expansion_ppm_per_k"},
        Old{"/identify", "turns", "orientation_errors"},
        Old{"/rejected/0", "turn_rad", "orientation_error_rad"}, Old{"/stream", "unproven", "unconfirmed"}})
    EXPECT_THAT(error_of(with(calibration_document(full_document()), old)), HasSubstr(refusal(old)));
  json::value severity = calibration_document(full_document());
  for (const Old& old : {Old{"", "doubt", "warning"}, Old{"", "refusal", "error"}}) {
    severity.at_pointer("/verdict/findings/0/severity") = old.key;
    EXPECT_THAT(error_of(severity.as_object()),
                HasSubstr("found \"" + std::string{old.key} + "\", renamed to '" + old.new_key + "'"));
  }

  DriftDocument drift;
  Filler{}(drift);
  for (const Old& old :
       {Old{"", "distance2", "chi2"}, Old{"", "degrees", "degrees_of_freedom"},
        Old{"", "probability", "p_value"}, Old{"/causes/0", "probability", "p_value"},
        Old{"/update", "wrong", "rejected"}, Old{"/update", "doubts", "warnings"},
        Old{"/update", "left_out", "leave_one_out"}, Old{"/update", "probability", "p_value"}}) {
    const auto read = from_json<DriftDocument>(with(drift_document(drift), old));
    EXPECT_THAT(read ? "" : read.error(), HasSubstr(refusal(old)));
  }

  FrameDocument frame;
  Filler{}(frame);
  for (const Old& old : {Old{"", "doubtful", "outliers"}, Old{"/points/0", "misfit_mm", "residual_mm"},
                         Old{"/readings/0", "turn_error_deg", "orientation_error_deg"},
                         Old{"/base_shift", "is_real", "significant"}}) {
    const auto read = read_frame_document(with(frame_document(frame), old));
    EXPECT_THAT(read ? "" : read.error(), HasSubstr(refusal(old)));
  }
}

TEST(DriftDocumentReader, ReadsBackEveryMemberThatIsWritten) {
  DriftDocument x;
  Filler{}(x);
  for (auto* causes : {&x.causes, &x.alternatives}) {
    causes->resize(4);
    for (std::size_t i = 0; i < 4; ++i) {
      DriftDocument::Cause& cause = (*causes)[i];
      cause = causes->front();
      cause.kind = static_cast<ChangeKind>(i);
      if (cause.kind != ChangeKind::Reflector) cause.smr = "";
      cause.joint = cause.kind == ChangeKind::JointZero ? 7 : 0;
      if (cause.kind != ChangeKind::Reading) cause.row = 0;
    }
  }
  const auto read = from_json<DriftDocument>(drift_document(x));
  ASSERT_TRUE(read) << read.error();
  EXPECT_TRUE(same(*read, x));
}

TEST(Iso9283DocumentReader, ReadsBackEveryMemberThatIsWrittenWithAnglesAndWithout) {
  Iso9283Document x;
  Filler{}(x);
  x.sets[1].characteristics.accuracy.abc_rad.reset();
  x.sets[1].characteristics.repeatability.abc_rad.reset();
  x.variations[1].variation.abc_rad.reset();
  x.drifts[1].drift.ap_abc_rad.reset();
  const auto read = read_iso9283_document(iso9283_document(x));
  ASSERT_TRUE(read) << read.error();
  EXPECT_TRUE(same(*read, x));
}

TEST(FrameDocumentReader, ReadsBackEveryMemberThatIsWritten) {
  FrameDocument x;
  Filler{}(x);
  x.points[1].p_mm.reset();
  const auto read = read_frame_document(frame_document(x));
  ASSERT_TRUE(read) << read.error();
  EXPECT_TRUE(same(*read, x));
}

TEST(CalibrationDocumentSchema, IsWhatTheLayoutsDescribe) {
  const std::string name = TRUEPOSE_SOURCE_DIR "/proto/control/report.schema.json";
  const std::string described = json::serialize(calibration_document_schema());
  if (std::getenv("TRUEPOSE_WRITE_SCHEMA")) std::ofstream{name} << described << "\n";
  std::ifstream file{name};
  const json::value schema = json::parse(std::string{std::istreambuf_iterator<char>{file}, {}});
  EXPECT_EQ(schema, json::parse(described))
      << "run this test with TRUEPOSE_WRITE_SCHEMA=1, then proto/control/write_tables.py";
}

TEST(CalibrationDocumentSchema, HasEveryMemberOfADocument) {
  const json::object schema = calibration_document_schema();
  const json::object& properties = schema.at("properties").as_object();
  const json::object document = calibration_document(full_document());
  for (const auto& [key, value] : document) EXPECT_TRUE(properties.contains(key)) << key;
  for (const auto& [key, value] : properties) EXPECT_TRUE(document.contains(key)) << key;
}

}  // namespace
}  // namespace record
}  // namespace truepose
