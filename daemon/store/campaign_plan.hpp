#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/store/store.hpp"

namespace truepose::daemon {

namespace sqlite {
class Database;
class Statement;
}  // namespace sqlite

/// A pose that a campaign means to measure, kept before the arm goes there.
struct PlannedPose {
  int pose = 0;  ///< its number in the campaign, from 1
  PointPurpose purpose = PointPurpose::Identify;
  JointVector q_target, q_commanded;
  int replaces = 0;  ///< number of the pose that failed, whose substitute it is; 0: it is none
};

/// What a campaign needs to resume after the end of the daemon, in addition to its points and skipped poses.
struct CampaignPlan {
  std::string order;       ///< what it is to do, as CampaignOrder's text
  int total = 0;           ///< poses over all phases, as far as they were known
  std::string identified;  ///< SHA-256 of what it had identified; empty: nothing yet
  std::vector<PlannedPose> poses;
};

/// A campaign continued after the daemon had ended.
struct Resumption : record::Interruption {
  /// Brings a point that is seen since then to where the tracker would have seen it when the campaign began.
  Eigen::Isometry3d X_first_now = Eigen::Isometry3d::Identity();
};

/// A campaign that may continue, and how far it is.
struct InterruptedCampaign {
  CampaignRecord record;
  int done = 0;  ///< poses measured
  int skipped = 0;
  int total = 0;
};

/// Why a campaign of this kind cannot be resumed after the daemon ended in the middle of it; empty: it can.
std::string_view reason_not_resumable(std::string_view kind);

/// Plans and interruptions of the campaigns in the store's file, whose thread calls this, while the store is
/// there.
class CampaignPlans {
 public:
  explicit CampaignPlans(sqlite::Database& database) : database_{&database} {}

  /// Part of the transaction that begins the campaign.
  sqlite::Statement begun(const std::string& campaign_id, const std::string& order, int total);

  /// @param total  poses over all phases as they are known now
  StoreResult<void> add_planned(const std::string& campaign_id, std::span<const PlannedPose> poses,
                                int total);
  StoreResult<void> keep_identified(const std::string& campaign_id, const std::string& sha256);
  StoreResult<std::optional<CampaignPlan>> plan(const std::string& campaign_id);

  /// The names and serial numbers of the devices, which are not known when a campaign begins.
  StoreResult<void> keep_identities(const CampaignRecord& campaign);

  /// Marks the campaigns that still run here, which those of a daemon that died do: as interrupted where they
  /// have a plan and may continue, else as failed.
  /// @return how many
  StoreResult<int> interrupt_running(const std::string& ended);
  StoreResult<std::vector<InterruptedCampaign>> interrupted();  ///< the last begun first
  /// Runs again. Error: it is not interrupted.
  StoreResult<void> resume(const std::string& campaign_id);
  StoreResult<void> add_resumption(const std::string& campaign_id, const Resumption& resumption);
  StoreResult<std::vector<Resumption>> resumptions(const std::string& campaign_id);

 private:
  sqlite::Database* database_;
};

}  // namespace truepose::daemon
