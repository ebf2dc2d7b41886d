#pragma once

#include <boost/json/fwd.hpp>
#include <string>
#include <vector>

namespace truepose::report {

/// A file that a page carries for download.
struct EmbeddedFile {
  std::string name, type, content;  ///< type: as in "text/csv"
  std::string about;                ///< one sentence
};

/// The measurements of a calibration document as a measurement file, from which `truepose calibrate` with the
/// document's arm comes to the same result; empty where an older document does not say where the points were.
std::string measurements_csv(const boost::json::object& document);

/// The links to the files, each of which is part of the page; empty for none.
std::string raw_data_section(const std::vector<EmbeddedFile>& files);

}  // namespace truepose::report
