#pragma once

#include <optional>
#include <string>
#include <vector>

#include "proto/rpc/method.hpp"

namespace truepose::rpc {

struct ToolInUse {
  int number = 0;
  std::optional<std::string> krl{};
  std::optional<std::string> refused{};
  std::optional<std::string> campaign_id{};
  std::optional<std::string> measured{};
};
void layout(Io& io, ToolInUse& x);

/// tool.list
struct ToolList : NoParameters {
  struct Result {
    std::vector<ToolInUse> tools{};
  };
  static const Method& method();
};
void layout(Io& io, ToolList::Result& x);

/// tool.activate
struct ToolActivate {
  using Result = ToolInUse;
  static const Method& method();

  std::string id{};
};
void layout(Io& io, ToolActivate& x);

/// tool.deactivate
struct ToolDeactivate {
  struct Result {
    std::string deactivated{};
  };
  static const Method& method();

  int number = 0;
};
void layout(Io& io, ToolDeactivate& x);
void layout(Io& io, ToolDeactivate::Result& x);

/// The methods of this file.
std::vector<Described> tool_methods();

}  // namespace truepose::rpc
