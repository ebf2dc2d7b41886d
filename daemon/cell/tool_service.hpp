#pragma once

#include <boost/asio/awaitable.hpp>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "daemon/cell/device_service.hpp"
#include "proto/rpc/tool.hpp"

namespace truepose::daemon {

/// The tools that are known by their numbers: those that campaigns measured and a client activated, then
/// those of the cell file.
class ToolService {
 public:
  ToolService(const CellParts& parts, CellRunner& runner, const DeviceService& devices)
      : parts_{parts}, runner_{runner}, devices_{devices} {}

  static std::vector<Served<ToolService>> methods();

  /// Takes those in use from the store.
  boost::asio::awaitable<StoreResult<void>> load();
  /// Null where none is known that has the number, or the one in use is refused.
  const config::ToolFile* of(int number) const;
  /// The campaign that measured it; empty: it is the cell file's.
  std::string campaign_of(int number) const;
  /// Why the tool in use is not to be worked with, in one sentence: its record is not the one that was
  /// stored, or it was measured on another arm than the connected one. Empty: it may be.
  std::string refusal(int number) const;
  /// The same of any in use.
  std::string refusal() const;
  /// Called when others are in use.
  void when_changed(std::function<void()> act) { changed_ = std::move(act); }

 private:
  struct InUse {
    std::string campaign_id, measured;
    std::expected<config::ToolFile, std::string> file;  ///< or why it is refused
  };

  Reply<rpc::ToolList> list(rpc::ToolList);
  Reply<rpc::ToolActivate> activate(rpc::ToolActivate request);
  Reply<rpc::ToolDeactivate> deactivate(rpc::ToolDeactivate request);
  std::set<int> numbers() const;
  std::expected<config::ToolFile, std::string> measured_by(const CampaignRecord& campaign) const;
  std::string other_arm(const std::string& what, const std::string& serial) const;
  rpc::ToolInUse in_use(int number) const;

  CellParts parts_;
  CellRunner& runner_;
  const DeviceService& devices_;
  std::map<int, InUse> in_use_;
  std::function<void()> changed_ = [] {};
};

}  // namespace truepose::daemon
