#pragma once

#include <vector>

#include "config/cell_config.hpp"
#include "daemon/check.hpp"
#include "proto/rsi/ethernet_config.hpp"

namespace truepose::daemon {

/// Whether the controller's datagrams and the daemon's socket meet: IP_NUMBER and PORT of its configuration
/// beside stream.listen and what this machine has.
std::vector<Finding> check_stream_address(const config::StreamConfig& stream,
                                          const rsi::EthernetConfig& ethernet);

/// Where the control port may be.
std::vector<Finding> check_control_address(const config::ControlConfig& control);

/// That no two keys of the cell file name one port of one host.
std::vector<Finding> check_ports(const config::CellConfig& config);

}  // namespace truepose::daemon
