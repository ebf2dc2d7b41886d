#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/cancellation_signal.hpp>
#include <expected>
#include <memory>
#include <string>
#include <variant>

#include "daemon/campaign/campaign_procedure.hpp"
#include "daemon/campaign/iso9283_campaign.hpp"
#include "daemon/campaign/measuring_session.hpp"
#include "daemon/campaign/targets_campaign.hpp"

namespace truepose::daemon {

struct CalibrationOrder {};

/// What a campaign is to do; a check of drift comes with the active model.
using CampaignOrder = std::variant<CalibrationOrder, DriftReference, TargetsOrder, Iso9283Order>;

/// One campaign, from connecting the devices to the end in the journal.
class Campaign {
 public:
  /// What is referred to outlives run().
  Campaign(config::CellConfig config, CampaignDevices devices, CampaignJournal& journal,
           CampaignObserver& observer, RunCompute run_compute, CampaignOrder order = CalibrationOrder{});

  /// Runs the whole campaign, once. It ends in the journal in every case. End it early by abort(), not by
  /// cancelling.
  boost::asio::awaitable<std::expected<std::shared_ptr<const CampaignResult>, CampaignError>> run();

  /// Takes effect before the next pose.
  void pause() { session_.pause(); }
  void resume() { session_.resume(); }
  /// Stops the arm. run() then returns Aborted with this reason.
  void abort(std::string reason);

  const CampaignProgress& progress() const { return session_.progress(); }

 private:
  CampaignOutcome<void> steps();

  config::CellConfig config_;
  MeasuringSession session_;
  std::unique_ptr<CampaignProcedure> procedure_;
  bool aborting_ = false;
  std::string abort_reason_;
  boost::asio::cancellation_signal cancel_;
};

}  // namespace truepose::daemon
