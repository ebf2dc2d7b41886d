#include "proto/rpc/report.hpp"

namespace truepose::rpc {

using record::Whole;

void layout(Io& io, ReportGet::Result& x) {
  io.about("The campaign").format("uuid")("id", x.id);
  io.refers("CalibrationDocument")("document", x.document);
  io.about("Of the longer list")("points_total", x.points_total);
}
void layout(Io& io, ReportGet& x) {
  io.about("Default: the newest that has one").format("uuid").optional("id", x.id, kIdSize);
  io.defaulted("points_offset", x.points_offset);
  io.about("Members of `points` and `remeasured_points` to list; the lists come in pages")
      .defaulted("points_limit", x.points_limit, Whole{0, 50});
}
const Method& ReportGet::method() {
  static const Method kMethod{
      .name = "report.get",
      .summary = "The calibration document of a campaign",
      .errors = {ErrorCode::NotFound, ErrorCode::Store},
      .is_long = true,
  };
  return kMethod;
}

void layout(Io& io, ReportHtml::Result& x) {
  io.about("The campaign").format("uuid")("id", x.id);
  io.about("As asked for")("offset", x.offset);
  io.about("The part")("html", x.html);
  io.about("Offset of the next part; null: there is none").nullable("next", x.next);
  io.about("Of the whole page, UTF-8")("bytes", x.bytes);
  io.about("When the page was made").format("date-time")("made", x.made);
}
void layout(Io& io, ReportHtml& x) {
  io.about("The campaign; left out: the last calibration that is done")
      .format("uuid")
      .optional("id", x.id, kIdSize);
  io.about("First byte of the part").optional("offset", x.offset);
}
const Method& ReportHtml::method() {
  static const Method kMethod{
      .name = "report.html",
      .summary = "The page that `truepose report --html` writes, in parts",
      .description =
          "The first part (offset 0) makes the page, with the stream's counters of now; the parts one "
          "after the other are it, where all were made at the same time. Continue with `next` until it is "
          "null.",
      .errors = {ErrorCode::Unauthenticated, ErrorCode::InvalidParams, ErrorCode::NotFound, ErrorCode::Store},
      .is_long = true,
  };
  return kMethod;
}

std::vector<Described> report_methods() { return {described<ReportGet>(), described<ReportHtml>()}; }

}  // namespace truepose::rpc
