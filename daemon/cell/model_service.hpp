#pragma once

#include <array>
#include <boost/asio/awaitable.hpp>
#include <cstdint>
#include <deque>
#include <expected>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/campaign/stored_model.hpp"
#include "daemon/cell/device_service.hpp"
#include "daemon/cell/store_watch.hpp"
#include "daemon/cell/tool_service.hpp"
#include "proto/rpc/model.hpp"

namespace truepose::daemon {

/// The models that the store has, and the one that is worked with.
class ModelService {
 public:
  struct Active {
    ModelRecord record;
    CalibratedCell cell;
    std::optional<DriftReference> drift_reference;
    std::optional<std::string> warning;  ///< its verdict, where that failed, and why
  };
  /// What the stream was given, by the number that it knows it by.
  struct Given {
    std::uint64_t number;
    ModelRecord record;
    CalibratedCell cell;      ///< its one reflector is the point that is kept
    std::optional<int> tool;  ///< number of the measured one that it corrects
    std::string tool_of;      ///< campaign that measured that; empty: the cell file's
  };
  /// The tool that the stream corrects.
  struct ActiveTool {
    std::optional<int> number;           ///< none: not known, or none
    std::optional<Eigen::Isometry3d> X;  ///< on the flange, as the controller has it; none: not known
    bool is_current = false;   ///< X is what it has now, not what it had when the tool was last used
    bool is_measured = false;  ///< else the accuracy holds for the reflector
  };
  /// Why the active model cannot be worked with, and what would change that.
  struct Lack {
    std::string why;
    std::string what_to_do;
    std::vector<std::string> allowed;  ///< methods that do it
  };
  /// A model as the store has it, and whether it still is the one that was made.
  struct Found {
    ModelRecord record;
    std::expected<StoredModel, std::string> checked;
  };

  ModelService(const CellParts& parts, CellRunner& runner, StoreWatch& store, const DeviceService& devices,
               ToolService& tools);

  static std::vector<Served<ModelService>> methods();

  /// Takes the active model from the store. One that is no longer what was made is not worked with, and is a
  /// fault until another is activated.
  boost::asio::awaitable<StoreResult<void>> load_active();
  const std::optional<Active>& active() const { return active_; }
  /// The controller says which tool is in effect and with which frame. Where the cell file says which, that
  /// holds.
  /// @param frame  X Y Z in mm, A B C in deg; none: not known yet, and the last one of this tool holds
  void controller_has(std::optional<int> tool, const std::optional<std::array<double, 6>>& frame);
  const ActiveTool& tool() const { return tool_; }
  const ToolService& tools() const { return tools_; }
  /// Why nothing can be corrected; none where it can be.
  std::optional<Lack> missing_for_correction() const;
  /// The active model where it can be worked with, else why it cannot, as the answer to who needs it.
  std::expected<const Active*, control::RpcError> needed() const;
  std::expected<const Active*, control::RpcError> needed_for_drift() const;
  /// The same for who corrects by it: the tools in use have to be the arm's too.
  std::expected<const Active*, control::RpcError> needed_to_correct() const;
  /// @param id  empty: the active one
  /// @return it; or that there is none, or that it is no longer what was made
  boost::asio::awaitable<std::expected<Found, control::RpcError>> find_checked(std::string id);
  /// A campaign has made a model.
  /// @param activated  and the store has activated it
  /// @param by         who started the campaign
  boost::asio::awaitable<void> announce_made(std::string id, bool activated, std::string by);
  std::optional<rpc::ModelSummary> active_summary() const;
  /// The store keeps the one that was activated, and that may have been refused since.
  bool is_in_effect(const std::string& id) const { return active_ && active_->record.id == id; }
  /// The last ones, the newest at the end.
  const std::deque<Given>& given() const { return given_; }

 private:
  Reply<rpc::ModelList> list(rpc::ModelList request);
  Reply<rpc::ModelGet> get(rpc::ModelGet request);
  Reply<rpc::ModelActivate> activate(rpc::ModelActivate request, std::string by);
  Reply<rpc::ModelRollback> rollback(rpc::ModelRollback, std::string by);
  Reply<rpc::ModelDeactivate> deactivate(rpc::ModelDeactivate, std::string by);
  Reply<rpc::ModelExport> export_yaml(rpc::ModelExport request);

  boost::asio::awaitable<std::expected<ModelRecord, control::RpcError>> find(std::string id);
  boost::asio::awaitable<StoreResult<std::optional<Found>>> read(std::string id);
  /// Why a model may not be activated; empty: it may.
  std::string why_not_activated(const Found& found) const;
  static Lack lacks_model(const std::string& why);
  control::RpcError refusal(const Lack& lack) const;
  std::optional<Lack> lack() const;
  void forget();
  void give_to_stream(const Active& model);
  void compare_frame();
  /// As it was given before, or made; the last one at the end.
  const Given& given_with_tool(const Active& model);
  /// Makes a model the active one, where nothing speaks against it.
  Reply<rpc::ModelActivate> make_active(std::string id, std::string by);
  void publish(const char* change, const ModelRecord& record, const std::string& by);

  CellParts parts_;
  CellRunner& runner_;
  StoreWatch& store_;
  const DeviceService& devices_;
  const ToolService& tools_;
  std::optional<Active> active_;
  std::optional<ModelRecord> refused_;  ///< that the store has as the active one, and that is not worked with
  ActiveTool tool_;
  std::map<int, Eigen::Isometry3d> frames_;  ///< of the tools that the controller has used, as it had them
  std::uint64_t number_ = 0;                 ///< of the model that the stream was given last
  std::deque<Given> given_;
};

}  // namespace truepose::daemon
