#pragma once

#include <boost/json/fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/report/report_document.hpp"

namespace truepose::report {

// The reports that commands print and write. Every page is one self-contained file: well-formed XML, no
// external file, and it prints without its script. A document of which a member is missing or of the wrong
// kind is refused by std::invalid_argument with one sentence that names the member.

/// Further documents with sections on a calibration's page; null where there is none.
struct FurtherDocuments {
  const boost::json::object* iso9283 = nullptr;  ///< as `truepose iso9283 --json` prints it
  const boost::json::object* frame = nullptr;    ///< as `truepose tool --json` prints it
};

/// The page of a calibration document. It carries the documents and the measurements for download. What a
/// document does not hold has no section.
std::string render_html(const ReportDocument& document, const FurtherDocuments& further = {});

/// The table of errors before and after each stage for a terminal, with the verdict below it, ending in a
/// newline.
std::string render_text(const ReportDocument& document);

/// Why a calibration must not be used, and what to do; empty: nothing is against it. By this a command ends
/// with its exit code.
std::string why_unusable(const ReportDocument& document);

/// The page of a production program that a model file judged, without a campaign. It carries the document and
/// the samples for download.
std::string render_production_html(const record::ProductionDocument& document);
/// What it comes to, for a terminal, ending in a newline.
std::string production_text(const record::Production& production);
/// Why the model must not correct the program, a clause; empty: nothing is against it.
std::string why_refuted(const record::Production& production);

/// A file that a page carries for download.
struct EmbeddedFile {
  std::string name, type, content;  ///< type: as in "text/csv"
  std::string about;                ///< one sentence
};

/// The page of an ISO 9283 document, as `truepose iso9283 --json` prints it, which it carries for download.
///
/// @param data_file  which was evaluated
/// @param files      what it was evaluated from, for download too
std::string render_iso9283_html(const boost::json::object& document, const std::string& data_file,
                                std::vector<EmbeddedFile> files);

/// What was done for one target: what was added to each joint (deg or mm), and what is left.
struct CompensationRow {
  double residual_mm = 0;
  double residual_deg = 0;
  std::optional<double> sigma_mm;
  bool damped = false;
  std::vector<double> corrections;
};

struct CompensationReport {
  std::string robot, targets;  ///< names
  bool position_only = false;
  std::vector<CompensationRow> rows;  ///< at least one, all with as many corrections
};

/// The page of compensated targets: corrections, residuals and standard deviations over the targets. Of very
/// many targets every k-th is drawn.
std::string render_compensation_html(const CompensationReport& report);

}  // namespace truepose::report
