#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/rpc/campaign.hpp"
#include "proto/rpc/method.hpp"

namespace truepose::rpc {

/// drift.check
struct DriftCheck {
  using Result = CampaignStart::Result;
  static const Method& method();

  std::optional<int> poses{};
  bool update = false;
  bool activate = false;
  std::optional<std::uint64_t> seed{};
  std::string note{};
};
void layout(Io& io, DriftCheck& x);
void check(const Io& io, const DriftCheck& x);

/// The methods of this file.
std::vector<Described> drift_methods();

}  // namespace truepose::rpc
