#include <memory>
#include <utility>

#include "core/formatted.hpp"
#include "core/frames/work_frame.hpp"
#include "daemon/campaign/campaign.hpp"

namespace truepose::daemon {

namespace {

class BaseCampaign final : public CampaignProcedure {
 public:
  BaseCampaign(MeasuringSession& session, BaseOrder order);
  CampaignOutcome<void> run() override;
  CampaignNeeds needs() const override { return {.moving_arm = false, .tracker = !order_.touch}; }

 private:
  CampaignOutcome<void> read(std::size_t point);
  CampaignOutcome<void> touch(std::size_t point);
  FrameReadings readings() const;
  CampaignOutcome<void> evaluate();
  std::string point_of_base(std::size_t point) const;
  std::string request(std::size_t point) const;
  std::string touch_request(std::size_t point, int touch) const;

  MeasuringSession& session_;
  BaseOrder order_;
};

}  // namespace

BaseCampaign::BaseCampaign(MeasuringSession& session, BaseOrder order)
    : session_{session}, order_{std::move(order)} {
  session_.result().findings = BaseResult{.order = order_};
  session_.progress().add_to_total(static_cast<int>(order_.points.size()) * order_.readings);
}

CampaignOutcome<void> BaseCampaign::run() {
  session_.progress().enter(CampaignPhase::Frame);
  Done done;
  for (std::size_t point = 0; done && point < order_.points.size(); ++point) {
    auto measured = order_.touch ? touch(point) : read(point);
    done = co_await std::move(measured);
  }
  if (done) done = co_await evaluate();
  co_return done;
}

std::string BaseCampaign::point_of_base(std::size_t point) const {
  return "point \"" + order_.points[point].point.name + "\" of base " + std::to_string(order_.number);
}

std::string BaseCampaign::request(std::size_t point) const {
  return "put the reflector at " + point_of_base(point) + ", opened to the tracker, then resume the campaign";
}

std::string BaseCampaign::touch_request(std::size_t point, int touch) const {
  const std::string which = " (" + std::to_string(touch) + " of " + std::to_string(order_.readings) +
                            (touch > 1 ? ", turned to another side" : "") + ")";
  return "touch " + point_of_base(point) + " with the TCP of tool " +
         std::to_string(order_.touch->tool.number) + (order_.readings > 1 ? which : "") +
         ", then resume the campaign";
}

/// Asks again where the tracker does not see it: without one of its points there is no frame.
CampaignOutcome<void> BaseCampaign::read(std::size_t point) {
  const FixturePoint& wanted = order_.points[point];
  const Eigen::Vector3d p_W_mm = order_.by.cell.base.isometry() * wanted.p_B_mm;
  const double search_mm = session_.config().tracker.first_search_radius_mm;
  co_await session_.wait_for_operator(request(point));
  for (int n = 0; n < order_.readings;) {
    const FixedReflector reflector{session_.plan().next_number(), wanted.point.name, PointPurpose::Frame};
    auto seen = co_await session_.measure_fixed(reflector, p_W_mm, search_mm);
    if (!seen) co_return std::unexpected(seen.error());
    if (*seen)
      ++n;
    else
      co_await session_.wait_for_operator("the tracker did not see it: " + request(point));
  }
  co_return Done{};
}

CampaignOutcome<void> BaseCampaign::touch(std::size_t point) {
  Done done;
  for (int n = 1; done && n <= order_.readings; ++n)
    done = co_await session_.touch(session_.plan().next_number(), order_.points[point].point.name,
                                   touch_request(point, n));
  co_return done;
}

FrameReadings BaseCampaign::readings() const {
  std::vector<FramePoint> points;
  for (const FixturePoint& point : order_.points) points.push_back(point.point);
  // What was touched no tracker's motion corrects.
  return readings_of_base(order_.touch ? session_.result().points : session_.corrected().points,
                          std::move(points));
}

CampaignOutcome<void> BaseCampaign::evaluate() {
  session_.progress().enter(CampaignPhase::Compute);
  BaseResult result{.order = order_, .data = readings()};
  TouchingTool tcp;
  if (order_.touch) tcp = {order_.touch->measured.X.translation(), &order_.touch->measured};
  auto job = [&result, tcp, this] { return work_frame(result.data, order_.by, tcp); };
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
