#pragma once

#include <Eigen/Core>
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/choices.hpp"
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
  std::optional<int> skipped{};
  std::optional<int> left{};
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

/// Which point it is, and what the tracker saw of it.
struct SeenPoint {
  int pose = 0;
  std::string purpose{};
  std::string smr{};
  std::optional<Eigen::Vector3d> p_mm{};
  std::optional<Eigen::Vector3d> std_mm{};
  std::optional<Eigen::Vector3d> abc_deg{};
  std::optional<double> std_abc_deg{};
};
/// Its members, in the record that has them.
void layout(Io& io, SeenPoint& x);

struct Point : SeenPoint {
  std::vector<double> q_target_deg{};
  std::vector<double> q_commanded_deg{};
  std::vector<double> q_actual_deg{};
  std::string time{};
};
void layout(Io& io, Point& x);

struct TargetsDocument {
  struct Target {
    int target = 0;
    bool reached = false;
    std::string reason{};
    std::vector<double> joints_deg{};
    std::vector<double> errors_mm{};
    double averaged_mm = 0;
  };
  double tolerance_mm = 0;
  int rounds = 0;
  int readings = 0;
  int reached = 0;
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

/// A pose: x, y, z in mm, then KUKA's a, b, c in deg.
using PoseRow = Eigen::Matrix<double, 6, 1>;

/// Of a campaign: the document of so many fits into one line of the protocol.
inline constexpr int kMostTargets = 100;

/// campaign.start. A kind refuses the parameters of others: a client that sends one empties those that have a
/// number to begin with.
struct CampaignStart {
  struct Result {
    std::string id{};
    int total = 0;
  };
  static const Method& method();

  std::string kind = "calibration";
  std::vector<std::vector<double>> joints{};
  std::vector<PoseRow> poses{};
  std::optional<int> rounds = 15;
  std::optional<double> tolerance_mm = 0.003;
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
  std::vector<std::string> points{};
  std::vector<Eigen::Vector3d> at{};
  std::optional<int> touch{};
  std::vector<Eigen::Vector3d> nominal{};
  std::vector<Eigen::Vector3d> facing{};
  std::vector<Eigen::Vector3d> orientation{};
  bool together = false;
  std::optional<int> poses_per_point = 10;
  std::string note{};
};
void layout(Io& io, CampaignStart& x);
/// That every parameter is of the kind, and that they fit each other.
void check(const Io& io, const CampaignStart& x);
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
    int identify_poses = 0;
    int validate_poses = 0;
    std::optional<double> validation_before_mm{};
    std::optional<double> validation_after_mm{};
    boost::json::object verdict{};
  };
  static const Method& method();

  std::string id{};
  std::optional<bool> non_geometric{};
  std::optional<std::vector<int>> harmonics{};
  std::optional<FieldUse> residual{};
  std::optional<Loss> loss{};
  std::optional<PriorUse> prior{};
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
  std::string format = "json";
  std::uint64_t offset = 0;
  int limit = 1000;
};
void layout(Io& io, CampaignPoints& x);
void layout(Io& io, CampaignPoints::Result& x);

/// The methods of this file.
std::vector<Described> campaign_methods();

}  // namespace truepose::rpc
