#include "tools/experiment/experiment_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/json/object.hpp>
#include <cstddef>
#include <utility>

#include "daemon/report/charts.hpp"
#include "daemon/report/json_node.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/page.hpp"
#include "proto/control/json_text.hpp"
#include "proto/xml/escape.hpp"

namespace truepose::report {
namespace {

std::string mm(const Node& error) { return error_text(error.number()); }

std::string_view color_of(const Node& method) {
  const std::string data = method["data"].text();
  return data == "noisy" ? kGeometricColor : data == "noise-free" ? kCompensatedColor : kBeforeColor;
}

std::string title_of(const Node& method) {
  const std::string data = method["data"].text();
  return method["method"].text() + (data == "noisy" ? "" : ", " + data);
}

bool converged(const Node& method) { return !method["validation"].is_null(); }

std::string methods_section(const Node& document) {
  Table table{"",
              {{},
               {"mean"},
               {"max"},
               {"RMS"},
               {"RMS / bound", "strong"},
               {"converged"},
               {"within 2 %<br/>of the oracle"},
               {"iterations"},
               {"time of<br/>a fit"}}};
  for (const Node& method : document["methods"].elements()) {
    std::vector<std::string> cells;
    for (const char* figure : {"mean", "max", "rms"})
      cells.push_back(converged(method) ? mm(method["validation"][figure]) : "-");
    const Node ratio = method["rmse_over_bound"], near_oracle = method["within_2_percent_of_oracle"];
    cells.push_back(ratio.is_null() ? "-" : fmt::format("{:.3f}", ratio.number()));
    cells.push_back(fmt::format("{:.1f} %", 100 * method["converged"].number()));
    cells.push_back(near_oracle.exists() ? fmt::format("{:.0f} %", 100 * near_oracle.number()) : "");
    cells.push_back(fmt::format("{:.1f}", method["iterations"].number()));
    cells.push_back(fmt::format("{:.1f} ms", 1000 * method["time_s"].number()));
    table.row(color_key(color_of(method)) + xml::escaped(title_of(method)), cells);
  }
  return section(
      "Methods",
      note(fmt::format(
          "All on the same {} trials, judged at validation poses against the true positions (mm). No unbiased "
          "method can have an RMS below the Cramer-Rao bound, here {} mm, apart from scatter: the ratio's standard "
          "deviation is 3 % over 40 trials and 1.3 % over 200.",
          document["trials"].integer(), mm(document["bound_rms"]))) +
          std::move(table).scrolled());
}

std::string spread_section(const Node& document) {
  std::vector<Box> boxes;
  for (const Node& method : document["methods"].elements()) {
    if (!converged(method) || method["data"].text() == "noise-free") continue;
    const Node errors = method["validation"];
    const Eigen::Vector3d quartiles = method["quartiles"].vector();
    boxes.push_back({title_of(method), color_of(method), errors["min"].number(), quartiles[0], quartiles[1],
                     quartiles[2], errors["max"].number()});
  }
  if (boxes.empty()) return "";
  return section(
      "How the errors are spread",
      note("Smallest to greatest error, the box from the lower to the upper quartile, the median in "
           "it. Methods with noise, on a logarithmic axis.") +
          box_chart_svg("3-D error at validation poses", "3-D error, mm", boxes),
      "whole");
}

/// The member `of_each` of every method with such data, over its running number.
std::string curves(const Node& document, std::string_view data, const char* of_each, std::string title,
                   std::string x_label) {
  PointChart chart{.title = std::move(title),
                   .x_label = std::move(x_label),
                   .y_unit = "mm, logarithmic",
                   .log_y = true,
                   .series = {}};
  for (const Node& method : document["methods"].elements()) {
    const std::vector<double> curve = method[of_each].numbers();
    if (method["data"].text() != data || curve.empty()) continue;
    Series series = series_of_palette(title_of(method), chart.series.size());
    for (std::size_t i = 0; i < curve.size(); ++i) {
      series.points.push_back({static_cast<double>(i + 1), curve[i],
                               fmt::format("{}, {}: {} mm", series.name, i + 1, error_text(curve[i]))});
    }
    chart.series.push_back(std::move(series));
  }
  return chart.series.empty() ? "" : boxed(point_chart_svg(chart));
}

std::string first_trial_section(const Node& document) {
  const std::string figures =
      curves(document, "noisy", "convergence", "RMS of the points to identify",
             "before iteration, coarse and then fine stage") +
      curves(document, "noisy", "errors", "3-D error at each validation pose", "pose") +
      curves(document, "outliers", "errors", "The same with outliers", "pose");
  if (figures.empty()) return "";
  return section("The first trial", note("How the methods converge, and what they leave.") + charts(figures),
                 "whole");
}

std::string designs_section(const Node& document) {
  Table table{"", {{}, {"poses"}, {"RMS", "strong"}, {"greatest"}}};
  for (const Node& design : document["designs"].elements()) {
    table.row(xml::escaped(design["design"].text()),
              {fmt::format("{}", design["poses"].integer()), mm(design["rms"]), mm(design["max"])});
  }
  return section(
      "Choice of poses",
      note("What the two-stage fit predicts at the poses of a task, from as many poses chosen in different "
           "ways. The greatest is that of the worst pose of the task, an RMS over the trials.") +
          std::move(table).scrolled());
}

std::string arm_title(const Node& layer) {
  const std::string arm = layer["rigid"].flag()
                              ? "Rigid arm"
                              : fmt::format("Heavy arm, backlash {} deg", layer["backlash_deg"].number());
  return fmt::format("{}, {} poses", arm, layer["poses"].integer());
}

std::string layers_section(const Node& document) {
  Table table{"", {{}, {"mean", "strong"}, {"max"}, {"RMS"}, {"RMS of the model"}}};
  std::string last;
  for (const Node& layer : document["layers"].elements()) {
    if (const std::string arm = arm_title(layer); arm != last) {
      table.group(arm);
      last = arm;
    }
    const Node errors = layer["validation"];
    const double model_rms = layer["model_rms"].number();
    table.row(xml::escaped(layer["layer"].text()), {mm(errors["mean"]), mm(errors["max"]), mm(errors["rms"]),
                                                    model_rms > 0 ? error_text(model_rms) : ""});
  }
  return section("Layers beyond geometry",
                 note("At fresh targets, against where the arm stood, its repeatability included; the last "
                      "column against where it stands on average.") +
                     std::move(table).scrolled());
}

std::string published_section(const Node& document) {
  Table table{"",
              {{},
               {"source", "text"},
               {"paper"},
               {"ours", "strong"},
               {.classes = "text", .style = "white-space: normal"}}};
  for (const Node& pair : document["published"].elements()) {
    table.row(xml::escaped(pair["figure"].text()),
              {xml::escaped(pair["source"].text()), mm(pair["published_mean"]), mm(pair["mean"]),
               xml::escaped(pair["explanation"].text())});
  }
  return section("The paper's figures and ours",
                 note("Mean position errors, mm.") + std::move(table).scrolled());
}

std::string identity_text(const Node& document) {
  const Node noise = document["noise"];
  return fmt::format("{} trials · seed {} · tracker {} mm and repeatability {} mm per axis",
                     document["trials"].integer(), document["seed"].natural(), mm(noise["tracker"]),
                     mm(noise["repeatability"]));
}

std::string bound_summary(const Node& document) {
  const std::vector<Node> methods = document["methods"].elements();
  const auto two_stage = std::ranges::find_if(methods, [](const Node& method) {
    return method["method"].text() == "two-stage" && method["data"].text() == "noisy";
  });
  if (two_stage == methods.end() || !converged(*two_stage)) return "";
  return section(
      "",
      fmt::format("<p class=\"eyebrow\">RMS error of the two-stage fit over the Cramer-Rao bound</p>\n"
                  "<p class=\"headline\"><span class=\"now\">{:.3f}</span></p>\n"
                  "<p>{} mm at validation poses; {} mm is the least that any unbiased method can reach on "
                  "average.</p>\n",
                  (*two_stage)["rmse_over_bound"].number(), mm((*two_stage)["validation"]["rms"]),
                  mm(document["bound_rms"])),
      "summary");
}

std::string experiment_sections(const boost::json::object& json) {
  const Node document{json, "experiment document"};
  std::string html =
      page_header("Experiment", "All methods on one simulated arm", identity_text(document), "part");
  for (const auto part : {bound_summary, methods_section, spread_section, first_trial_section,
                          designs_section, layers_section, published_section}) {
    html += part(document);
  }
  return html;
}

}  // namespace

std::string render_experiment_html(const boost::json::object& document) {
  return html_page("Calibration experiment",
                   experiment_sections(document) + raw_data_section({{"experiment.json", "application/json",
                                                                      control::json_text(document) + "\n",
                                                                      "every figure of this page"}}));
}

}  // namespace truepose::report
