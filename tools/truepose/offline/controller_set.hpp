#pragma once

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "config/cell_config.hpp"
#include "proto/rsi/context.hpp"

namespace truepose::tools {

/// Of the interpreter, and of RSI in #IPO.
inline constexpr std::chrono::milliseconds kSlowRsiCycle{12};

/// What the controller's RSI context has to agree with.
rsi::ContextDemands demands_of(const config::CellConfig& cell);

/// Versions of the controller's software that there are files for; 9 is iiQKA.OS2.
std::vector<std::string_view> kss_names();
bool is_iiqka(std::string_view kss);

/// A file of the controller: where it goes below the folder of the set, and there.
struct ControllerFile {
  std::string name;         ///< "EthernetKRL/CellLink.xml"
  std::string destination;  ///< on the controller
  std::string text;
};

/// The files that a controller loads, with the cell's addresses, limits and cycle; of iiQKA.OS2 those that it
/// can load. Throws ConfigError where the controller could not send to stream.listen.
/// @param cell_file  for the error
/// @param kss        of kss_names()
std::vector<ControllerFile> controller_files_of(const config::CellConfig& cell, const std::string& cell_file,
                                                std::string_view kss);

}  // namespace truepose::tools
