#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "tools/sim/krl/value.hpp"

namespace truepose::sim {

/// What was set of the system variables: by name and, of arrays, by index from 1.
class SystemValues {
 public:
  static constexpr int kNoArray = 0;

  /// @return null where nothing was set
  const krl::Value* find(std::string_view name, int index = kNoArray) const {
    const auto found = values_.find(name);
    const auto at = static_cast<std::size_t>(index);
    if (found == values_.end() || at >= found->second.size()) return nullptr;
    const krl::Value& value = found->second[at];
    return std::holds_alternative<std::monostate>(value) ? nullptr : &value;
  }

  krl::Value& at(std::string_view name, int index = kNoArray) {
    auto found = values_.find(name);
    if (found == values_.end()) found = values_.try_emplace(std::string{name}).first;
    const auto at = static_cast<std::size_t>(index);
    if (at >= found->second.size()) found->second.resize(at + 1);
    return found->second[at];
  }

  void erase(std::string_view name) {
    if (const auto found = values_.find(name); found != values_.end()) values_.erase(found);
  }
  void clear() { values_.clear(); }

 private:
  struct Hash : std::hash<std::string_view> {
    using is_transparent = void;
  };

  std::unordered_map<std::string, std::vector<krl::Value>, Hash, std::equal_to<>> values_;
};

}  // namespace truepose::sim
