#include "daemon/campaign/identification.hpp"

#include <gmock/gmock.h>

#include <algorithm>

#include "core/formatted.hpp"
#include "tests/daemon/example_calibration.hpp"
#include "tests/daemon/example_cell.hpp"

namespace truepose::daemon {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string sentences(const CalibrationVerdict& verdict) {
  std::string all;
  for (const Finding& finding : verdict.findings) all += finding.sentence + '\n';
  return all;
}

TEST(AVerdict, NamesCompensatedPosesThatTheModelItselfExpectsToStayOff) {
  const config::CellConfig config = test::example_cell();
  const CampaignResult campaign = test::example_calibration();
  CalibrationResult result = campaign.as<CalibrationResult>();
  ASSERT_THAT(sentences(verdict_on(result, campaign.points, config, {})), Not(HasSubstr("stay off")));
  const auto validates = std::ranges::find(campaign.points, PointPurpose::Validate, &StoredPoint::purpose);
  ASSERT_NE(validates, campaign.points.end());
  StoredPoint again = *validates;
  again.purpose = PointPurpose::Remeasure;
  again.q_commanded = again.q_target;  // not corrected at all
  result.remeasured_points.push_back({again, {0, 0, 0}});
  EXPECT_THAT(sentences(verdict_on(result, campaign.points, config, {})),
              HasSubstr(formatted("by the model these stay off: pose %d (", validates->pose)));
}

}  // namespace
}  // namespace truepose::daemon
