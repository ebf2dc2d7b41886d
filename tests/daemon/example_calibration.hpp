#pragma once

#include <cstdint>

#include "daemon/campaign/campaign_result.hpp"

namespace truepose::test {

/// What a sound campaign of the example cell comes to: 16 poses to identify, 12 to validate, measured with
/// the noise that its cell file states.
daemon::CampaignResult example_calibration(std::uint64_t seed = 1);

}  // namespace truepose::test
