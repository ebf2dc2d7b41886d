#include "daemon/store/campaign_plan.hpp"

#include <algorithm>
#include <utility>

#include "daemon/store/joint_list.hpp"
#include "daemon/store/sqlite.hpp"

namespace truepose::daemon {

using sqlite::Statement;

namespace {

constexpr int kPoseNumbers = 12;  // of a matrix of three rows and four columns

std::string pose_text(const Eigen::Isometry3d& X) {
  std::vector<double> numbers;
  for (int i = 0; i < kPoseNumbers; ++i) numbers.push_back(X(i / 4, i % 4));
  return list_text(numbers);
}

std::optional<Eigen::Isometry3d> pose_of(std::string_view text) {
  const auto numbers = numbers_of(text);
  if (!numbers || numbers->size() != kPoseNumbers) return std::nullopt;
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (int i = 0; i < kPoseNumbers; ++i) X(i / 4, i % 4) = (*numbers)[static_cast<std::size_t>(i)];
  return X;
}

std::unexpected<StoreError> unreadable(const std::string& campaign_id, const char* what) {
  return std::unexpected(StoreError{"reading campaign " + campaign_id + ": " + what});
}

/// What the daemon that comes after finds to say of a campaign that may not continue.
std::string failed_reason(std::string_view kind) {
  const std::string_view reason = reason_not_resumable(kind);
  return "the daemon ended in the middle of it" +
         (reason.empty() ? std::string{} : "; " + std::string{reason});
}

}  // namespace

std::string_view reason_not_resumable(std::string_view kind) {
  if (kind == "iso9283") return "a test by ISO 9283 is one series of cycles without a break: start it again";
  if (kind == "drift") return "a drift check asks how the arm is now, in a few minutes: start it again";
  if (kind == "base")
    return "a fixture is read in a few minutes, in which it has to stand still: start it again";
  return {};
}

Statement CampaignPlans::begun(const std::string& campaign_id, const std::string& order, int total) {
  Statement insert = database_->prepare("INSERT INTO plan VALUES (?,?,?,'')");
  insert.bind(campaign_id).bind(order).bind(std::int64_t{total});
  return insert;
}

StoreResult<void> CampaignPlans::add_planned(const std::string& campaign_id,
                                             std::span<const PlannedPose> poses, int total) {
  std::vector<Statement> statements;
  for (const PlannedPose& planned : poses) {
    statements.push_back(database_->prepare(
        "INSERT INTO planned (campaign_id, pose, purpose, q_target, q_commanded, replaces) "
        "SELECT ?,?,?,?,?,nullif(?,0) WHERE NOT EXISTS (SELECT 1 FROM planned WHERE campaign_id=?1 AND pose=?2 "
        "AND purpose=?3 AND q_target=?4 AND q_commanded=?5)"));
    statements.back().bind(campaign_id).bind(std::int64_t{planned.pose}).bind(purpose_name(planned.purpose));
    statements.back().bind(list_text(planned.q_target)).bind(list_text(planned.q_commanded));
    statements.back().bind(std::int64_t{planned.replaces});
  }
  statements.push_back(database_->prepare("UPDATE plan SET total=? WHERE campaign_id=?"));
  statements.back().bind(std::int64_t{total}).bind(campaign_id);
  std::vector<Statement*> all;
  for (Statement& statement : statements) all.push_back(&statement);
  return sqlite::commit(*database_, "storing the plan of campaign " + campaign_id, all);
}

StoreResult<void> CampaignPlans::keep_identified(const std::string& campaign_id, const std::string& sha256) {
  Statement update = database_->prepare("UPDATE plan SET identified=? WHERE campaign_id=?");
  update.bind(sha256).bind(campaign_id);
  return sqlite::commit(*database_, "storing what campaign " + campaign_id + " has identified", {&update});
}

StoreResult<std::optional<CampaignPlan>> CampaignPlans::plan(const std::string& campaign_id) {
  Statement query = database_->prepare("SELECT task, total, identified FROM plan WHERE campaign_id=?");
  query.bind(campaign_id);
  const StoreResult<bool> row = query.step();
  if (!row) return std::unexpected(row.error());
  if (!*row) return std::nullopt;
  CampaignPlan plan{query.document(0), static_cast<int>(query.integer(1)), query.text(2), {}};

  Statement poses = database_->prepare(
      "SELECT pose, purpose, q_target, q_commanded, ifnull(replaces, 0) FROM planned WHERE campaign_id=? ORDER BY pose");
  poses.bind(campaign_id);
  for (;;) {
    const StoreResult<bool> more = poses.step();
    if (!more) return std::unexpected(more.error());
    if (!*more) return plan;
    const auto target = joints_of(poses.text(2)), commanded = joints_of(poses.text(3));
    const auto purpose = purpose_of(poses.text(1));
    if (!target || !commanded || !purpose)
      return unreadable(campaign_id, "the joints of a planned pose are no list of numbers");
    plan.poses.push_back({static_cast<int>(poses.integer(0)), *purpose, *target, *commanded,
                          static_cast<int>(poses.integer(4))});
  }
}

StoreResult<void> CampaignPlans::keep_identities(const CampaignRecord& c) {
  Statement update = database_->prepare(
      "UPDATE campaign SET robot_model=?, robot_serial=?, tracker_model=?, tracker_serial=? WHERE id=?");
  update.bind(c.robot_model).bind(c.robot_serial).bind(c.tracker_model).bind(c.tracker_serial).bind(c.id);
  return sqlite::commit(*database_, "storing the devices of campaign " + c.id, {&update});
}

StoreResult<int> CampaignPlans::interrupt_running(const std::string& ended) {
  std::vector<Statement> statements;
  Statement running = database_->prepare(
      "SELECT id, kind, EXISTS (SELECT 1 FROM plan WHERE campaign_id=id) FROM campaign WHERE state='running'");
  for (;;) {
    const StoreResult<bool> row = running.step();
    if (!row) return std::unexpected(row.error());
    if (!*row) break;
    const bool may_go_on = running.integer(2) != 0;
    statements.push_back(database_->prepare("UPDATE campaign SET ended=?, state=?, reason=? WHERE id=?"));
    statements.back().bind(ended).bind(std::string_view{may_go_on ? "interrupted" : "failed"});
    statements.back().bind(may_go_on ? "the daemon ended in the middle of it"
                                     : failed_reason(running.text(1)));
    statements.back().bind(running.text(0));
  }
  if (statements.empty()) return 0;
  std::vector<Statement*> all;
  for (Statement& statement : statements) all.push_back(&statement);
  const StoreResult<void> result = sqlite::commit(*database_, "marking campaigns that were interrupted", all);
  if (!result) return std::unexpected(result.error());
  return static_cast<int>(statements.size());
}

StoreResult<std::vector<InterruptedCampaign>> CampaignPlans::interrupted() {
  // A pose is one number, seen in both faces or not; nests and checks are none.
  Statement query = database_->prepare(R"sql(
    SELECT id, kind, started, ended, reason, robot_model, robot_serial, tracker_model, tracker_serial,
      started_by, note, total,
      (SELECT count(*) FROM point WHERE campaign_id=id AND purpose NOT IN ('nest', 'face1', 'check')),
      (SELECT count(*) FROM skipped WHERE campaign_id=id)
    FROM campaign JOIN plan ON campaign_id=id WHERE state='interrupted' ORDER BY campaign.rowid DESC)sql");
  std::vector<InterruptedCampaign> all;
  for (;;) {
    const StoreResult<bool> row = query.step();
    if (!row) return std::unexpected(row.error());
    if (!*row) return all;
    InterruptedCampaign& one = all.emplace_back();
    one.record = {.id = query.text(0),
                  .kind = query.text(1),
                  .started = query.text(2),
                  .ended = query.text(3),
                  .state = "interrupted",
                  .reason = query.text(4),
                  .robot_model = query.text(5),
                  .robot_serial = query.text(6),
                  .tracker_model = query.text(7),
                  .tracker_serial = query.text(8),
                  .model_id = {},
                  .document = {},
                  .started_by = query.text(9),
                  .note = query.text(10)};
    one.total = static_cast<int>(query.integer(11));
    one.done = static_cast<int>(query.integer(12));
    one.skipped = static_cast<int>(query.integer(13));
  }
}

StoreResult<void> CampaignPlans::resume(const std::string& campaign_id) {
  Statement update = database_->prepare(
      "UPDATE campaign SET state='running', ended='', reason='' WHERE id=? AND state='interrupted'");
  update.bind(campaign_id);
  const std::string operation = "resuming campaign " + campaign_id;
  const StoreResult<void> resumed = sqlite::commit(*database_, operation, {&update});
  if (!resumed) return resumed;
  if (database_->changes() != 1) return std::unexpected(StoreError{operation + ": it is not interrupted"});
  return {};
}

StoreResult<void> CampaignPlans::add_resumption(const std::string& campaign_id,
                                                const Resumption& resumption) {
  Statement insert = database_->prepare(
      "INSERT INTO resumption (campaign_id, interrupted, resumed, found, x_first_now) SELECT ?,?,?,?,? WHERE NOT EXISTS "
      "(SELECT 1 FROM resumption WHERE campaign_id=?1 AND interrupted=?2 AND resumed=?3)");
  insert.bind(campaign_id).bind(resumption.interrupted).bind(resumption.resumed).bind(resumption.found);
  insert.bind(pose_text(resumption.X_first_now));
  return sqlite::commit(*database_, "storing that campaign " + campaign_id + " resumes", {&insert});
}

StoreResult<std::vector<Resumption>> CampaignPlans::resumptions(const std::string& campaign_id) {
  Statement query = database_->prepare(
      "SELECT interrupted, resumed, found, x_first_now FROM resumption WHERE campaign_id=? ORDER BY number");
  query.bind(campaign_id);
  std::vector<Resumption> all;
  for (;;) {
    const StoreResult<bool> row = query.step();
    if (!row) return std::unexpected(row.error());
    if (!*row) return all;
    const auto X = pose_of(query.text(3));
    if (!X) return unreadable(campaign_id, "the motion of the tracker is no list of 12 numbers");
    all.push_back({{query.text(0), query.text(1), query.text(2)}, *X});
  }
}

}  // namespace truepose::daemon
