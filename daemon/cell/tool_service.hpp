#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/json/object.hpp>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "daemon/cell/device_service.hpp"

namespace truepose::daemon {

/// The tools that are known by their numbers: those that campaigns measured and somebody took into use, then
/// those of the cell file.
class ToolService {
 public:
  ToolService(const CellParts& parts, CellRunner& runner, const DeviceService& devices)
      : parts_{parts}, runner_{runner}, devices_{devices} {}

  static std::vector<Method<ToolService>> methods();

  /// Takes those in use from the store.
  boost::asio::awaitable<StoreResult<void>> load();
  /// Null where none is known that has the number.
  const config::ToolFile* of(int number) const;
  /// The campaign that measured it; empty: it is the cell file's.
  std::string campaign_of(int number) const;
  /// That the one in use was measured on another arm than the one that is there, in one sentence; empty: it
  /// was not, or nobody knows.
  std::string other_arm(int number) const;
  /// The same of any in use.
  std::string other_arm() const;
  /// Called when others are in use.
  void when_changed(std::function<void()> act) { changed_ = std::move(act); }

 private:
  struct InUse {
    std::string campaign_id, measured, robot_serial;
    config::ToolFile file;
  };

  MethodReply list(boost::json::object params);
  MethodReply activate(boost::json::object params, std::string by);
  MethodReply deactivate(boost::json::object params, std::string by);
  std::expected<InUse, std::string> usable(const ToolInUse& stored) const;
  std::string why_not(const CampaignRecord& record) const;
  std::string other_arm(const std::string& what, const std::string& serial) const;
  boost::json::object json(int number) const;

  CellParts parts_;
  CellRunner& runner_;
  const DeviceService& devices_;
  std::map<int, InUse> in_use_;
  std::function<void()> changed_ = [] {};
};

}  // namespace truepose::daemon
