#include "tools/report/html_page.hpp"

#include <fmt/format.h>

#include "proto/xml/escape.hpp"
#include "tools/report/page_script.hpp"
#include "tools/report/report_style.hpp"

namespace truepose::report {

std::string html_page(std::string_view title, std::string_view body) {
  return fmt::format(
      "<!DOCTYPE html>\n<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\">\n<head>\n<meta "
      "charset=\"utf-8\"/>\n<meta name=\"viewport\" content=\"width=device-width, "
      "initial-scale=1\"/>\n<title>{}</title>\n<style>{}</style>\n</head>\n<body>\n<main>\n{}"
      "<footer>Written by truepose {}. Lengths in mm, angles in "
      "degrees.</footer>\n</main>\n<script>{}</script>\n"
      "</body>\n</html>\n",
      xml::escaped(title), kStyleSheet, body, TRUEPOSE_VERSION, kPageScript);
}

std::string page_header(std::string_view kind, std::string_view title, std::string_view identity) {
  std::string html =
      fmt::format("<header>\n<p class=\"eyebrow\">{}</p>\n<h1>{}</h1>\n", kind, xml::escaped(title));
  if (!identity.empty()) html += fmt::format("<p class=\"identity\">{}</p>\n", xml::escaped(identity));
  return html + "</header>\n";
}

}  // namespace truepose::report
