#include "daemon/campaign/campaign.hpp"

#include <boost/asio/bind_cancellation_slot.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <optional>
#include <utility>

#include "daemon/campaign/campaign_options.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;

Campaign::Campaign(config::CellConfig config, CampaignDevices devices, CampaignJournal& journal,
                   CampaignObserver& observer, RunJob run_compute, CampaignOrder order,
                   std::shared_ptr<const CampaignPast> past)
    : config_{std::move(config)},
      reason_not_resumable_{reason_not_resumable(order)},
      model_serial_{model_serial(order)},
      session_{config_, devices, journal, observer, std::move(run_compute), std::move(past)},
      procedure_{std::visit([this](auto of_kind) { return procedure_of(session_, std::move(of_kind)); },
                            std::move(order))} {}

asio::awaitable<std::expected<std::shared_ptr<const CampaignResult>, CampaignError>> Campaign::run() {
  const auto executor = co_await asio::this_coro::executor;
  std::optional<CampaignError> error;
  if (!aborting_) {
    // The steps have a cancellation of their own, so that after an abort the arm can still be stopped and the
    // end written.
    auto token = asio::bind_cancellation_slot(cancel_.slot(), asio::use_awaitable);
    try {
      Done done = co_await asio::co_spawn(executor, steps(), token);
      if (!done) error = done.error();
    } catch (const std::exception& e) {
      error = CampaignError{CampaignFault::Internal, e.what()};
    }
  }
  if (aborting_) {
    error = CampaignError{CampaignFault::Aborted, abort_reason_, interrupting_};
    auto stopped = co_await session_.devices().stop();
    if (!stopped && session_.has_begun())
      error->detail += "; the arm could not be braked and may still move, use the stop on the pendant: " +
                       stopped.error().detail;
  }
  // What was measured before is as good as it was.
  if (error && !aborting_ && session_.past().resumes() && !session_.past().has_resumed()) {
    error->detail = "it did not resume: " + error->detail;
    error->interrupted = true;
  }
  auto ended = co_await session_.end(error);
  if (!ended && !error) error = CampaignError{CampaignFault::Store, ended.error().detail};
  if (error) co_return std::unexpected(*error);
  co_return session_.shared_result();
}

CampaignOutcome<void> Campaign::steps() {
  Done done = co_await session_.connect(procedure_->needs(), model_serial_);
  if (done) done = co_await procedure_->run();
  if (done) done = co_await session_.past().note_resumption();
  if (done) session_.progress().enter(CampaignPhase::Finish);
  co_return done;
}

void Campaign::abort(std::string reason) {
  if (aborting_) return;
  aborting_ = true;
  abort_reason_ = std::move(reason);
  cancel_.emit(asio::cancellation_type::terminal);
}

void Campaign::interrupt(std::string reason) {
  if (aborting_) return;
  interrupting_ = reason_not_resumable_.empty();
  abort(interrupting_ ? std::move(reason) : reason + "; " + reason_not_resumable_);
}

}  // namespace truepose::daemon
