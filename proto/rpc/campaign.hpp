#pragma once

#include <Eigen/Core>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/record/campaign_records.hpp"
#include "proto/record/iso9283_document.hpp"
#include "proto/rpc/method.hpp"

namespace truepose::rpc {

struct CampaignProgress {
  static constexpr auto kTopic = control::Topic::Campaign;

  std::string id{};
  std::string kind{};
  std::string phase{};
  int done = 0;
  int total = 0;
  std::optional<double> error_mm{};
  std::optional<double> eta_s{};
  std::optional<std::uint64_t> skipped{};
  std::optional<std::uint64_t> left{};
  std::optional<std::string> reason{};
  std::optional<std::string> trouble{};
  std::optional<std::string> model_id{};
};
void layout(Io& io, CampaignProgress& x);

struct CampaignSummary {
  std::string id{};
  std::string kind{};
  std::string started{};
  std::optional<std::string> ended{};
  std::string state{};
  std::string reason{};
  std::string robot_model{};
  std::string robot_serial{};
  std::string tracker_model{};
  std::string tracker_serial{};
  std::optional<std::string> by{};
  std::string note{};
  std::optional<std::string> model_id{};
  std::optional<std::string> points_of{};
};
void layout(Io& io, CampaignSummary& x);

struct InterruptedCampaign {
  std::string id{};
  std::string kind{};
  std::string started{};
  std::string interrupted{};
  int done = 0;
  int total = 0;
  std::string reason{};
};
void layout(Io& io, InterruptedCampaign& x);

struct Point {
  int pose = 0;
  std::string purpose{};
  std::string smr{};
  std::vector<double> q_target_deg{};
  std::vector<double> q_commanded_deg{};
  std::vector<double> q_actual_deg{};
  std::optional<Eigen::Vector3d> p_mm{};
  std::optional<Eigen::Vector3d> std_mm{};
  std::optional<Eigen::Vector3d> abc_deg{};
  std::optional<double> std_abc_deg{};
  std::string time{};
};
void layout(Io& io, Point& x);

struct TargetsDocument {
  struct Target {
    std::uint64_t target = 0;
    bool reached = false;
    std::string reason{};
    std::vector<double> joints_deg{};
    std::vector<double> errors_mm{};
    double averaged_mm = 0;
  };
  double tolerance_mm = 0;
  int rounds = 0;
  int readings = 0;
  std::uint64_t reached = 0;
  std::vector<Target> targets{};
};
void layout(Io& io, TargetsDocument& x);

/// The document of `truepose iso9283`, and how it was measured.
struct Iso9283Document {
  struct Cube {
    Eigen::Vector3d center_mm{0, 0, 0};
    double edge_mm = 0;
  };
  struct Commanded {
    std::string point{};
    std::string direction{};
    Eigen::Vector3d p_mm{0, 0, 0};
  };
  record::Iso9283Document test{};
  bool compensated = false;
  Cube cube{};
  std::vector<Commanded> commanded{};
};
void layout(Io& io, Iso9283Document& x);

/// campaign.start
struct CampaignStart {
  struct Result {
    std::string id{};
    int total = 0;
  };
  static const Method& method();

  std::string kind = "calibration";
  std::optional<std::vector<std::vector<double>>> joints{};
  std::optional<std::vector<std::vector<double>>> poses{};
  int rounds = 15;
  double tolerance_mm = 0.003;
  std::optional<int> readings{};
  std::optional<int> cycles{};
  std::optional<bool> variation{};
  bool compensate = true;
  std::optional<int> identify_poses{};
  std::optional<int> validate_poses{};
  std::optional<std::uint64_t> seed{};
  std::optional<bool> remeasure{};
  bool activate = true;
  std::optional<int> number{};
  std::optional<std::vector<std::string>> points{};
  std::optional<std::vector<Eigen::Vector3d>> at{};
  std::optional<int> touch{};
  std::optional<std::vector<Eigen::Vector3d>> nominal{};
  std::optional<std::vector<Eigen::Vector3d>> facing{};
  std::optional<std::vector<Eigen::Vector3d>> orientation{};
  bool together = false;
  int poses_per_point = 10;
  std::optional<std::string> note{};
};
void layout(Io& io, CampaignStart& x);
void layout(Io& io, CampaignStart::Result& x);

/// campaign.pause
struct CampaignPause : NoParameters {
  using Result = CampaignProgress;
  static const Method& method();
};

/// campaign.resume
struct CampaignResume {
  using Result = CampaignProgress;
  static const Method& method();

  std::optional<std::string> id{};
};
void layout(Io& io, CampaignResume& x);

/// campaign.abort
struct CampaignAbort {
  using Result = CampaignProgress;
  static const Method& method();

  std::optional<std::string> id{};
};
void layout(Io& io, CampaignAbort& x);

/// campaign.identify
struct CampaignIdentify {
  struct Result {
    std::string id{};
    std::string points_of{};
    std::string model_id{};
    bool activated = false;
    std::string reason{};
    std::uint64_t identify_poses = 0;
    std::uint64_t validate_poses = 0;
    std::optional<double> validation_before_mm{};
    std::optional<double> validation_after_mm{};
    boost::json::object verdict{};
  };
  static const Method& method();

  std::string id{};
  std::optional<std::string> non_geometric{};
  std::optional<std::vector<int>> harmonics{};
  std::optional<std::string> residual{};
  std::optional<std::string> loss{};
  std::optional<std::string> prior{};
  std::optional<bool> correct_by_nests{};
  std::optional<double> split{};
  std::optional<std::uint64_t> seed{};
  bool activate = false;
};
void layout(Io& io, CampaignIdentify& x);
void layout(Io& io, CampaignIdentify::Result& x);

/// campaign.export
struct CampaignExport {
  struct Result {
    std::string id{};
    std::uint64_t offset = 0;
    std::string data{};
  };
  static const Method& method();

  std::optional<std::string> id{};
  std::uint64_t offset = 0;
};
void layout(Io& io, CampaignExport& x);
void layout(Io& io, CampaignExport::Result& x);

/// campaign.list
struct CampaignList {
  struct Result {
    std::vector<CampaignSummary> campaigns{};
    int total = 0;
  };
  static const Method& method();

  int limit = 20;
  std::uint64_t offset = 0;
};
void layout(Io& io, CampaignList& x);
void layout(Io& io, CampaignList::Result& x);

/// campaign.get
struct CampaignGet {
  struct Result {
    CampaignSummary campaign{};
    std::optional<CampaignProgress> progress{};
    std::vector<record::SkippedPose> skipped{};
    std::vector<record::Interruption> interruptions{};
    boost::json::value drift{};  ///< null, or a DriftDocument as it was stored; the others likewise
    boost::json::value targets{};
    boost::json::value iso9283{};
    boost::json::value frame{};
    std::uint64_t points_total = 0;
    std::vector<Point> points{};
  };
  static const Method& method();

  std::optional<std::string> id{};
  std::uint64_t points_offset = 0;
  int points_limit = 0;
};
void layout(Io& io, CampaignGet& x);
void layout(Io& io, CampaignGet::Result& x);

/// campaign.points
struct CampaignPoints {
  struct Result {
    std::string id{};
    std::string format{};
    std::uint64_t offset = 0;
    std::optional<std::uint64_t> next{};
    int total = 0;
    std::optional<std::vector<Point>> points{};
    std::optional<std::string> csv{};
  };
  static const Method& method();

  std::optional<std::string> id{};
  std::optional<std::string> format{};
  std::optional<std::uint64_t> offset{};
  std::optional<int> limit{};
};
void layout(Io& io, CampaignPoints& x);
void layout(Io& io, CampaignPoints::Result& x);

/// drift.check
struct DriftCheck {
  struct Result {
    std::string id{};
    int total = 0;
  };
  static const Method& method();

  std::optional<int> poses{};
  std::optional<bool> update{};
  std::optional<bool> activate{};
  std::optional<std::uint64_t> seed{};
  std::optional<std::string> note{};
};
void layout(Io& io, DriftCheck& x);
void layout(Io& io, DriftCheck::Result& x);

/// The methods of this file.
std::vector<Described> campaign_methods();

}  // namespace truepose::rpc
