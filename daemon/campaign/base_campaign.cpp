#include <memory>
#include <utility>

#include "core/formatted.hpp"
#include "core/identify/work_frame.hpp"
#include "daemon/campaign/campaign.hpp"

namespace truepose::daemon {

namespace {

using Done = std::expected<void, CampaignError>;

class BaseCampaign final : public CampaignProcedure {
 public:
  BaseCampaign(MeasuringSession& session, BaseOrder order);
  CampaignOutcome<void> run() override;
  bool moves_arm() const override { return false; }

 private:
  CampaignOutcome<void> read(std::size_t point);
  CampaignOutcome<void> evaluate();
  std::string wish(std::size_t point) const;

  MeasuringSession& session_;
  BaseOrder order_;
};

}  // namespace

BaseCampaign::BaseCampaign(MeasuringSession& session, BaseOrder order)
    : session_{session}, order_{std::move(order)} {
  session_.result().findings = BaseResult{.order = order_};
  session_.add_to_total(static_cast<int>(order_.points.size()) * order_.readings);
}

CampaignOutcome<void> BaseCampaign::run() {
  session_.enter(CampaignPhase::Frame);
  Done done;
  for (std::size_t point = 0; done && point < order_.points.size(); ++point) done = co_await read(point);
  if (done) done = co_await evaluate();
  co_return done;
}

std::string BaseCampaign::wish(std::size_t point) const {
  return "put the reflector at point \"" + order_.points[point].point.name + "\" of base " +
         std::to_string(order_.number) + ", opened to the tracker, then resume the campaign";
}

/// Asks again where the tracker does not see it: without one of its points there is no frame.
CampaignOutcome<void> BaseCampaign::read(std::size_t point) {
  const FixturePoint& wanted = order_.points[point];
  const Eigen::Vector3d p_W_mm = order_.by.cell.base.isometry() * wanted.p_B_mm;
  const double search_mm = session_.config().tracker.search_first_mm;
  std::string sentence = wish(point);
  co_await session_.wait_for_hand(sentence);
  for (int n = 0; n < order_.readings;) {
    const MeasuringSession::Beside beside{session_.next_number(), wanted.point.name, PointPurpose::Frame};
    auto seen = co_await session_.measure_beside(beside, p_W_mm, search_mm);
    if (!seen) co_return std::unexpected(seen.error());
    if (*seen) {
      ++n;
      continue;
    }
    sentence = "the tracker did not see it: " + wish(point);
    co_await session_.wait_for_hand(sentence);
  }
  co_return Done{};
}

CampaignOutcome<void> BaseCampaign::evaluate() {
  session_.enter(CampaignPhase::Compute);
  std::vector<FramePoint> points;
  for (const FixturePoint& point : order_.points) points.push_back(point.point);
  BaseResult result{.order = order_, .data = frame_readings(session_.corrected().points, std::move(points))};
  // The arm had no part in them.
  for (FrameReading& reading : result.data.readings) reading.q.resize(0);
  auto job = [&result, this] { return work_frame(result.data, order_.by, {}); };
  auto frame = co_await session_.compute(job);
  if (!frame) co_return std::unexpected(CampaignError{CampaignFault::Calibration, frame.error()});
  result.frame = *std::move(frame);
  session_.result().findings = std::move(result);
  co_return Done{};
}

std::unique_ptr<CampaignProcedure> procedure_of(MeasuringSession& session, BaseOrder order) {
  return std::make_unique<BaseCampaign>(session, std::move(order));
}

}  // namespace truepose::daemon
