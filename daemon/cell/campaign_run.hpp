#pragma once

#include <string>
#include <utility>

#include "daemon/cell/daemon_cell.hpp"

namespace truepose::daemon {

/// One campaign of a cell: under way, or the last one.
struct DaemonCell::CampaignRun {
  CampaignRun(StoreJournal::Options options, const config::CellConfig& config, const Parts& parts,
              CampaignObserver& observer, RunCompute compute, CampaignOrder order)
      : id{options.campaign_id},
        journal{std::move(options), parts.store, parts.store_thread, parts.wall_clock},
        campaign{
            config,          {parts.robot, parts.tracker, parts.clock}, journal, observer, std::move(compute),
            std::move(order)} {}

  std::string id;
  StoreJournal journal;
  Campaign campaign;
  bool ended = false;
};

}  // namespace truepose::daemon
