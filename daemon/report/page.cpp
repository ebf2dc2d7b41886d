#include "daemon/report/page.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <cstddef>

#include "proto/text/digest.hpp"
#include "proto/xml/escape.hpp"

namespace truepose::report {
namespace {

std::string attribute(std::string_view name, std::string_view value) {
  return value.empty() ? "" : fmt::format(" {}=\"{}\"", name, value);
}

std::string heading_cell(std::string_view title, std::string_view classes, std::string_view spans = {}) {
  return fmt::format("<th{}{}>{}</th>", attribute("class", classes), spans, title);
}

std::string_view heading_class(const Column& column) {
  return column.classes.find("first") == std::string_view::npos ? "" : "first";
}

/// The titles in one line, or in two where columns have groups; nothing where no column has a title.
std::string table_head(const std::vector<Column>& columns) {
  if (std::ranges::all_of(columns, &std::string_view::empty, &Column::title)) return "";
  const bool grouped = !std::ranges::all_of(columns, &std::string_view::empty, &Column::group);
  std::string groups, titles;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Column& column = columns[i];
    if (grouped && column.group.empty()) {
      groups += heading_cell(column.title, heading_class(column), " rowspan=\"2\"");
      continue;
    }
    if (grouped && (i == 0 || columns[i - 1].group != column.group)) {
      const auto size = std::ranges::count(columns, column.group, &Column::group);
      groups += heading_cell(column.group, "group", fmt::format(" colspan=\"{}\"", size));
    }
    titles += heading_cell(column.title, heading_class(column));
  }
  return fmt::format("<thead>\n{}<tr>{}</tr>\n</thead>\n",
                     grouped ? fmt::format("<tr>{}</tr>\n", groups) : "", titles);
}

std::string base64(std::string_view bytes) {
  std::string text((bytes.size() + 2) / 3 * 4 + 1, '\0');  // OpenSSL ends it by a zero
  std::vector<unsigned char> in(bytes.begin(), bytes.end());
  text.resize(static_cast<std::size_t>(EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                                                       in.data(), static_cast<int>(in.size()))));
  return text;
}

}  // namespace

// Whatever was written into a text of the page, no other script runs.
std::string html_page(std::string_view title, std::string_view body) {
  const std::string script = fmt::format("\n{}", page_js());
  return fmt::format(
      "<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\">\n<head>\n"
      "<meta charset=\"utf-8\"/>\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src 'sha256-{}'; "
      "style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'\"/>\n"
      "<title>{}</title>\n<style>\n{}</style>\n</head>\n<body>\n<main>\n{}"
      "<footer>Written by truepose {}. Lengths in mm, angles in degrees.</footer>\n</main>\n"
      "<script>{}</script>\n</body>\n</html>\n",
      base64(text::sha256(script)), xml::escaped(title), page_css(), body, TRUEPOSE_VERSION, script);
}

std::string page_header(std::string_view kind, std::string_view title, std::string_view identity,
                        std::string_view classes) {
  std::string html = fmt::format("<header{}>\n<p class=\"eyebrow\">{}</p>\n<h1>{}</h1>\n",
                                 attribute("class", classes), xml::escaped(kind), xml::escaped(title));
  if (!identity.empty()) html += fmt::format("<p class=\"identity\">{}</p>\n", xml::escaped(identity));
  return html + "</header>\n";
}

std::string section(std::string_view title, std::string_view body, std::string_view classes) {
  return fmt::format("<section{}>\n{}{}</section>\n", attribute("class", classes),
                     title.empty() ? "" : fmt::format("<h2>{}</h2>\n", title), body);
}

std::string note(std::string_view text) { return fmt::format("<p class=\"note\">{}</p>\n", text); }

std::string charts(std::string_view svgs, std::string_view classes) {
  return fmt::format("<div class=\"{}\">\n{}</div>\n", classes, svgs);
}

std::string boxed(std::string_view svg) { return fmt::format("<div>{}</div>\n", svg); }

std::string sentence_list(std::string_view title, const std::vector<std::string>& sentences) {
  if (sentences.empty()) return "";
  std::string html = fmt::format("<h3>{}</h3>\n<ul class=\"sentences\">\n", title);
  for (const std::string& sentence : sentences) html += fmt::format("<li>{}</li>\n", sentence);
  return html + "</ul>\n";
}

std::string color_key(std::string_view color) {
  return fmt::format("<span class=\"key\" style=\"background: {}\"></span>", color);
}

std::string bar(double percent, std::string_view color) {
  return fmt::format("<span class=\"bar\"><i style=\"width: {:.2f}%; background: {}\"></i></span>", percent,
                     color);
}

Table::Table(std::string_view classes, std::vector<Column> columns)
    : columns_{std::move(columns)},
      html_{fmt::format("<table{}>\n{}", attribute("class", classes), table_head(columns_))} {}

void Table::group(std::string_view title) {
  html_ += fmt::format("{}<tbody>\n<tr><th class=\"rows\" colspan=\"{}\" scope=\"rowgroup\">{}</th></tr>\n",
                       in_group_ ? "</tbody>\n" : "", columns_.size(), title);
  in_group_ = true;
}

void Table::row(std::string_view name, const std::vector<std::string>& cells, std::string_view classes) {
  html_ += fmt::format("{}<tr{}><th scope=\"row\">{}</th>", in_group_ ? "" : "<tbody>\n",
                       attribute("class", classes), name);
  in_group_ = true;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Column& column = columns_[i + 1];
    html_ += fmt::format("<td{}{}>{}</td>", attribute("class", column.classes),
                         attribute("style", column.style), cells[i]);
  }
  html_ += "</tr>\n";
}

std::string Table::element() && { return std::move(html_) + (in_group_ ? "</tbody>\n</table>" : "</table>"); }

std::string Table::scrolled() && {
  return fmt::format("<div class=\"scroll\">{}</div>\n", std::move(*this).element());
}

std::string facts_table(std::string_view title, const Facts& facts) {
  Table table{"", {{}, {}}};
  bool known = false;
  for (const auto& [name, value] : facts) {
    if (value.empty()) continue;
    table.row(name, {value});
    known = true;
  }
  if (!known) return "";
  return fmt::format("<div class=\"facts\">\n{}{}\n</div>\n",
                     title.empty() ? "" : fmt::format("<h3>{}</h3>\n", title), std::move(table).element());
}

std::string raw_data_section(const std::vector<EmbeddedFile>& files) {
  if (files.empty()) return "";
  std::string links;
  for (const EmbeddedFile& file : files) {
    links +=
        fmt::format("<li><a download=\"{0}\" href=\"data:{1};base64,{2}\">{0}</a> ({3:.0f} kB): {4}</li>\n",
                    xml::escaped(file.name), file.type, base64(file.content),
                    std::max(1.0, static_cast<double>(file.content.size()) / 1000), file.about);
  }
  return section("Raw data",
                 note("This page carries its input files: every figure can be computed again.") +
                     fmt::format("<ul class=\"files\">\n{}</ul>\n", links),
                 "whole raw");
}

}  // namespace truepose::report
