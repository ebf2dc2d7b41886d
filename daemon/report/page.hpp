#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/report/report.hpp"

namespace truepose::report {

// What pages are made of. Texts are HTML, escaped already, unless said otherwise; classes are those of
// page.css, a space between two.

// One colour per stage, from Okabe and Ito's palette, which colour-blind readers can distinguish. On paper
// the marker's shape differs.
inline constexpr std::string_view kBeforeColor = "#d55e00";
inline constexpr std::string_view kGeometricColor = "#0072b2";
inline constexpr std::string_view kLayersColor = "#7b4fa3";
inline constexpr std::string_view kCompensatedColor = "#00805e";

/// The text of page.css. Holds no '<' or '&', so that the page stays well-formed XML; as does page.js.
std::string_view page_css();
/// The text of page.js: turns the clouds by dragging, and hands out embedded files as blobs, because browsers
/// limit the length of a link. Without it the page lacks nothing else.
std::string_view page_js();

/// One self-contained page: well-formed XML, no external file.
///
/// @param title  plain text
/// @param body   what is in <main>, well-formed
std::string html_page(std::string_view title, std::string_view body);

/// The heading of a page, or of a part of it. All plain text.
///
/// @param kind      what it is, "Calibration report"
/// @param identity  below the title, may be empty
std::string page_header(std::string_view kind, std::string_view title, std::string_view identity = {},
                        std::string_view classes = {});

std::string section(std::string_view title, std::string_view body, std::string_view classes = {});
/// A paragraph in small print.
std::string note(std::string_view text);
/// Charts side by side.
std::string charts(std::string_view svgs, std::string_view classes = "charts");
/// A chart in a box of its own, which has the width of its column.
std::string boxed(std::string_view svg);
/// A list of sentences below a heading; empty without any.
std::string sentence_list(std::string_view title, const std::vector<std::string>& sentences);
/// A patch of the colour that something has in charts.
std::string color_key(std::string_view color);
/// A bar of that part of its greatest length.
std::string bar(double percent, std::string_view color);

/// A column of a table.
struct Column {
  std::string_view title = {};
  std::string_view classes = {};  ///< of its cells; of its heading "first" alone, which sets a column apart
  std::string_view group = {};    ///< heading over this and the next columns of the same group
  std::string_view style = {};    ///< of its cells
};

/// A table in the making. The first column names the rows.
class Table {
 public:
  Table(std::string_view classes, std::vector<Column> columns);

  /// Starts a group of rows below a heading of its own.
  void group(std::string_view title);
  /// @param cells  one for each column after the first
  void row(std::string_view name, const std::vector<std::string>& cells, std::string_view classes = {});

  /// The <table> element.
  std::string element() &&;
  /// The same in a box in which it can be scrolled sideways.
  std::string scrolled() &&;

 private:
  std::vector<Column> columns_;
  std::string html_;
  bool in_group_ = false;
};

/// Names and values.
using Facts = std::vector<std::pair<std::string, std::string>>;
/// A table of them below a heading, if it has one. Left out are facts of which the value is not known
/// (empty), and the table where there are none.
std::string facts_table(std::string_view title, const Facts& facts);

/// A section with links to the files, each of which is part of the page; empty for none.
std::string raw_data_section(const std::vector<EmbeddedFile>& files);

}  // namespace truepose::report
