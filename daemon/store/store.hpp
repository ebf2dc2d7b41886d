#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/data/measurement.hpp"
#include "daemon/store/audit_witness.hpp"
#include "daemon/store/backup.hpp"
#include "daemon/store/event_archive.hpp"
#include "daemon/store/store_error.hpp"
#include "daemon/store/store_schema.hpp"
#include "proto/record/campaign_records.hpp"

namespace truepose::daemon {

using record::SkippedPose;

enum class PointPurpose {
  Identify,
  Validate,
  Remeasure,  ///< a validation pose again, with compensated joints
  Reference,  ///< one and the same pose again and again, so that drift shows
  Target,     ///< a round of the tracker loop at a target
  Cycle,      ///< a pose of a cycle of an ISO 9283 test
  Nest,       ///< a fixed reflector near the arm, which shows a drift of the tracker
  Face1,      ///< what face 1 alone saw of the pose of this number, whose point is the mean of both faces
  Check,      ///< the pose or the nest of this number once more, to see what moved during an interruption
  Frame,      ///< of a point of a tool or of a fixture, by which its frame is found
};

/// The names in the store and on the wire, in the order of the enumerators.
inline constexpr std::array<std::string_view, 10> kPurposes{
    "identify", "validate", "remeasure", "reference", "target", "cycle", "nest", "face1", "check", "frame"};
inline std::string_view purpose_name(PointPurpose purpose) {
  return kPurposes[static_cast<std::size_t>(purpose)];
}
inline std::optional<PointPurpose> purpose_of(std::string_view name) {
  for (std::size_t i = 0; i < kPurposes.size(); ++i)
    if (kPurposes[i] == name) return static_cast<PointPurpose>(i);
  return std::nullopt;
}
/// Whether it is a pose of the campaign, and not a further measurement that corrects or checks it.
inline bool is_pose(PointPurpose purpose) {
  return purpose != PointPurpose::Nest && purpose != PointPurpose::Face1 && purpose != PointPurpose::Check;
}

/// One measured point of a campaign, as it is kept.
struct StoredPoint {
  int pose = 0;  ///< its number in the campaign, from 1
  PointPurpose purpose = PointPurpose::Identify;
  JointVector q_target;                    ///< the pose that was wanted (rad, mm)
  JointVector q_commanded;                 ///< what was sent: differs from it when compensated
  JointVector q_actual;                    ///< what the controller reported at the end
  std::vector<std::int8_t> direction;      ///< in which each joint moved last (-1, 1; 0 or empty: not known)
  std::string smr;                         ///< the reflector, or the point that it was put to
  std::optional<Eigen::Vector3d> p_WS_mm;  ///< as the tracker read it; none: the arm's TCP touched the point
  // Of the tracker's reading.
  std::optional<MeasuredOrientation> orientation;  ///< of a 6-D target
  Eigen::Vector3d std_mm{0, 0, 0};
  double temperature_c = 0, pressure_mbar = 0, humidity_percent = 0;
  std::string time;    ///< RFC 3339
  int resumption = 0;  ///< measured after so many interruptions of the campaign

  /// What the tracker read, in another frame of it.
  void transform(const Eigen::Isometry3d& X) {
    p_WS_mm = X * *p_WS_mm;
    if (orientation) orientation->R_WT = X.linear() * orientation->R_WT;
  }
};

/// Lets these poses validate, and identify the others that were measured to either.
void assign_validation_set(const std::vector<int>& poses, std::vector<StoredPoint>& points);

struct CampaignRecord {
  std::string id;                    ///< UUID
  std::string kind = "calibration";  ///< or "drift", "targets", "iso9283", "tool", "base"
  std::string started;               ///< RFC 3339
  std::string ended;                 ///< empty while it runs; of one that was interrupted, when
  std::string state;                 ///< "running", "done", "aborted", "failed", "interrupted"
  std::string reason;  ///< for aborted, failed and interrupted, and why a model was not activated
  std::string robot_model, robot_serial, tracker_model, tracker_serial;
  std::string model_id;  ///< of the model that it made, or empty
  std::string document;  ///< the calibration document (JSON), or empty
  /// Of the document, by the store when the campaign ended; empty: ended before documents carried it.
  std::string document_sha256{};
  std::string started_by{};  ///< the name of who did; empty: not known
  std::string note{};        ///< his words for it, or empty
  std::string points_of{};   ///< the campaign that measured the points; empty: its own
  std::optional<std::vector<int>>
      validate{};  ///< of an identification: the poses that validate in it; none: as measured
};

struct ModelRecord {
  std::string id;       ///< UUID
  std::string created;  ///< RFC 3339
  std::string campaign_id;
  std::string robot_serial;
  std::string yaml;  ///< model file
  double validation_before_mm = 0, validation_after_mm = 0;
  bool active = false;
  /// Of a joint over the poses that it was made from, deg (of a slide, as many 180/pi metres); 0: stored
  /// before that was said.
  double largest_correction_deg = 0;
  std::string sha256;  ///< of the yaml, by the store when it took the model; empty: stored before that
};

/// A measured tool that is in effect under its number.
struct ToolInUse {
  int number = 0;           ///< of TOOL_DATA
  std::string campaign_id;  ///< that measured it
};

class CampaignPlans;

/// The cell's memory: one SQLite file (WAL, synchronous=FULL). A call that returned without an error is on
/// the disk. After a failed write or sync nothing more is taken until try_again(): what the kernel still has
/// of it is unknown. A full disk is no such failure; any call may be tried again.
/// Not thread-safe: owned by the store thread. UUIDs and times are the caller's.
class Store final : public EventArchive, public AuditWitness {
 public:
  /// Opens or makes the file, checks it and brings its schema up to date.
  static StoreResult<Store> open(const std::filesystem::path& file, SchemaSteps steps = kSchemaSteps);
  /// Opens an existing file to read what is in it, while a daemon has it open too. One of an older version is
  /// read into memory. Changes nothing in it.
  static StoreResult<Store> open_to_read(const std::filesystem::path& file, SchemaSteps steps = kSchemaSteps);
  /// Whether open() would take an existing file. Changes nothing in it.
  static StoreResult<void> examine(const std::filesystem::path& file);
  Store(Store&&) noexcept;
  Store& operator=(Store&&) noexcept;
  ~Store() override;

  /// Begins a copy of the store as it is when the last step of it is done.
  /// @param file  where it is to be
  StoreResult<StoreBackup> begin_backup(const std::filesystem::path& file);
  /// Makes a copy of a store, or an old one, the one of today: the stream is not armed, and events have
  /// numbers that no daemon has given.
  /// @param beyond  the last number that may have been given
  StoreResult<void> begin_new_life(std::uint64_t beyond);
  /// The last number that was reserved for events.
  StoreResult<std::uint64_t> last_event_number();

  /// Whether its file and its log are still those at their paths: what is written to others is lost. What a
  /// lost log holds is brought into the file.
  StoreResult<void> in_place();
  /// After a failure: reopens the file if its device failed, which checks it, and writes to it.
  /// @return whether it can be used again
  StoreResult<void> try_again();

  /// @param order  what it is to do, so that it may continue after the end of the daemon; empty: it may not
  /// @param total  poses over all phases as they are known then
  StoreResult<void> begin_campaign(const CampaignRecord& campaign, const std::string& order = "",
                                   int total = 0);
  // After an error the commit may or may not be on the disk. So a campaign may repeat each write, and the
  // store keeps it once.
  StoreResult<void> add_point(const std::string& campaign_id, const StoredPoint& point);
  StoreResult<void> add_skipped(const std::string& campaign_id, const SkippedPose& skipped);
  /// Writes state, end, reason, model and document of a campaign, and in the same transaction the model that
  /// it made, the active one from then on if it says so. A copy of the file alone then holds all of it.
  StoreResult<void> end_campaign(const CampaignRecord& campaign, const std::optional<ModelRecord>& made = {});
  /// What lets campaigns continue. Not beyond the store's life.
  CampaignPlans plans();
  StoreResult<std::vector<CampaignRecord>> campaigns();  ///< the last begun first, without documents
  StoreResult<std::optional<CampaignRecord>> campaign(const std::string& id);
  StoreResult<std::optional<CampaignRecord>> last_campaign();     ///< begun
  StoreResult<std::optional<CampaignRecord>> last_calibration();  ///< begun, of those that were done
  /// Of an identification those of the campaign that it is of, with the purpose that they have in it.
  StoreResult<std::vector<StoredPoint>> points(const std::string& campaign_id);
  StoreResult<std::vector<SkippedPose>> skipped(const std::string& campaign_id);

  StoreResult<void> add_model(const ModelRecord& model);
  /// In one transaction: this model active, every other not. An empty id deactivates.
  StoreResult<void> activate_model(const std::string& id);
  StoreResult<std::vector<ModelRecord>> models();  ///< the last made first, without yaml
  StoreResult<std::optional<ModelRecord>> model(const std::string& id);
  StoreResult<std::optional<ModelRecord>> active_model();
  /// The one that was active last and is not now.
  StoreResult<std::optional<ModelRecord>> model_before();

  /// From now on the tool that this campaign measured is in effect under its number; none without a campaign.
  StoreResult<void> use_tool(int number, const std::string& campaign_id);
  StoreResult<std::vector<ToolInUse>> tools_in_use();  ///< in the order of their numbers

  StoreResult<void> keep_audit_head(const control::AuditHead& head) override;
  StoreResult<std::vector<control::AuditHead>> audit_heads() override;

  /// @param since  RFC 3339, when the stream was armed; empty: it is not
  StoreResult<void> keep_armed(const std::string& since);
  StoreResult<std::string> armed_since();

  /// Reserves numbers of events, so that none repeats over restarts.
  /// @return the first of `count` numbers (from 1 on) that were never given before
  StoreResult<std::uint64_t> reserve_event_numbers(std::uint64_t count);
  /// The same at the start of a daemon: what the one before it may not have kept is a gap from now on.
  StoreResult<std::uint64_t> begin_events(std::uint64_t count);
  StoreResult<void> keep_events(const EventBatch& batch) override;
  /// The last ones: nothing is missing behind them.
  StoreResult<void> end_events(const EventBatch& batch);
  StoreResult<EventPage> events(const std::set<control::Topic>& topics, std::uint64_t first,
                                std::uint64_t end) override;
  StoreResult<std::vector<EventGap>> event_gaps(std::uint64_t first, std::uint64_t end) override;
  StoreResult<bool> prune_events(const std::string& before) override;

 private:
  struct Impl;
  explicit Store(std::unique_ptr<Impl> impl);
  StoreResult<std::uint64_t> first_reserved(std::uint64_t count);
  StoreResult<void> keep_events(const EventBatch& batch, std::string_view mark);
  StoreResult<bool> forget_events(const std::string& which, const std::string& before);
  std::unique_ptr<Impl> impl_;
};

}  // namespace truepose::daemon
