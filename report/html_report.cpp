#include "report/html_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "report/assets.h"
#include "report/chart_json.h"
#include "report/sections.h"
#include "report/tables.h"
#include "report/text.h"
#include "report/verdict.h"
#include "report/words/warning_words.h"

namespace sixdial::report {
namespace {

// No network by the browser's own rule, and nothing but what the page itself carries.
constexpr std::string_view kPolicy =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:; "
    "base-uri 'none'; form-action 'none'";

class Page {
 public:
  Page(const ReportData& data, bool with_charts)
      : data_(data), with_charts_(with_charts), charts_(nlohmann::json::object()) {}

  std::string text() {
    const std::string name =
        data_.head.session_name.empty() ? "unnamed session" : data_.head.session_name;
    put("<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n");
    put("<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n", kPolicy);
    // Light for everyone: colours mean something here, and paper and screen must agree.
    put("<meta name=\"color-scheme\" content=\"only light\">\n");
    put("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n");
    put("<meta name=\"generator\" content=\"Sixdial {}\">\n",
        escape_html(data_.head.software_version));
    put("<title>{} \u2013 {}</title>\n", escape_html(data_.head.title), escape_html(name));
    put("<style>\n{}</style>\n</head>\n<body>\n", assets::stylesheet());
    head();
    put("<main>\n");
    state();
    const std::vector<Section> sections = sections_of(data_);
    contents(sections);
    std::vector<const Chart*> charts;
    for (const Section& s : sections) {
      for (const Block& block : s.blocks) {
        if (const auto* f = std::get_if<Figure>(&block)) charts.push_back(&f->chart);
      }
    }
    marks_ = marks_allowed(charts);
    bool annex = false;
    for (std::size_t i = 0; i < sections.size(); ++i) {
      if (sections[i].in_annex && !annex) {
        annex = true;
        number_ = 0;
        put("<div class=\"annex\" id=\"annex\">\n<h2>Annex</h2>\n<p>Details for whoever wants "
            "to check or repeat the work. Nothing in it is needed to use the result.</p>\n"
            "</div>\n");
      }
      section(sections[i], section_ids_[i]);
    }
    put("</main>\n");
    foot();
    scripts();
    put("</body>\n</html>\n");
    return std::move(out_);
  }

 private:
  template <typename... Args>
  void put(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), format, std::forward<Args>(args)...);
  }

  /// An id that this page does not have yet: the second "table" becomes "table_2".
  std::string new_id(std::string_view wanted) {
    const std::string id = key_of(wanted);
    const int n = ++ids_[id];
    return n == 1 ? id : new_id(fmt::format("{}_{}", id, n));
  }

  void fact(std::string_view name, const std::string& value) {
    put("<div><dt>{}</dt><dd>{}</dd></div>\n", name,
        value.empty() ? "<span class=\"none\">not recorded</span>"
                      : "<bdi>" + escape_html(value) + "</bdi>");
  }

  void head() {
    const Head& h = data_.head;
    put("<header>\n<div class=\"title\">\n<p class=\"brand\">Sixdial</p>\n<h1>{}</h1>\n",
        escape_html(h.title));
    put("<p class=\"disclaimer\">Not an accredited certificate. It states what was measured "
        "and computed, with what, and how well.</p>\n</div>\n<dl class=\"facts\">\n");
    fact("Session", h.session_name);
    fact("Rig", h.rig_name);
    fact("Robot", h.robot);
    fact("Operator", h.operator_name);
    if (!h.place.empty()) fact("Place", h.place);
    fact("Measured", measured());
    fact(
        "Report made",
        readable_time(h.reported) + (!h.reported.empty() && h.reported < h.measured_to
                                         ? ", by a clock that is behind that of the samples"
                                         : ""));
    const auto result = result_index(data_);
    const std::string method = result ? data_.methods[*result].name : "";
    if (!data_.opening) {
      fact("Method", h.profile.empty() || !result ? method : method + ", profile " + h.profile);
    }
    fact(
        "Temperature", h.temperature_min_c && h.temperature_max_c
                           ? fmt::format(
                                 "{} to {} \u00B0C", fixed(*h.temperature_min_c, 1),
                                 fixed(*h.temperature_max_c, 1))
                           : "");
    fact("Instruments", instruments());
    fact(
        "Traceability",
        h.traced.parts.empty()
            ? ""
            : counted(std::ssize(h.traced.parts), "part", "parts") + ", see the annex");
    fact(
        "Software", h.software_version.empty()
                        ? ""
                        : "Sixdial " + h.software_version +
                              (h.seed ? fmt::format(", seed {}", *h.seed) : ""));
    fact("Data", short_hash(h.data_hash));
    fact("Rig file", short_hash(h.rig_hash));
    put("</dl>\n</header>\n");
  }

  /// "6 digital dial indicators, resolution 0.001 mm": what they share.
  [[nodiscard]] std::string instruments() const {
    const auto& all = data_.head.instruments;
    if (all.empty()) return "";
    const bool alike = std::ranges::all_of(
        all, [&](const ShownDial& each) { return each.description == all[0].description; });
    std::string out = fmt::format(
        "{} {}", all.size(),
        alike && all.size() > 1 ? all[0].description + "s"
        : alike                 ? all[0].description
                                : std::string("dial indicators"));
    if (all[0].resolution_mm && std::ranges::all_of(all, [&](const ShownDial& each) {
          return each.resolution_mm == all[0].resolution_mm;
        })) {
      out += fmt::format(", resolution {} mm", exact(*all[0].resolution_mm));
    }
    return out;
  }
  /// Enough of it to compare by eye; the whole hash is with the provenance.
  static std::string short_hash(const std::string& hash) {
    constexpr std::size_t kLetters = 19;  // "sha256:" and twelve digits
    return hash.size() > kLetters ? hash.substr(0, kLetters) + "\u2026" : hash;
  }

  [[nodiscard]] std::string measured() const {
    const std::string from = readable_time(data_.head.measured_from);
    const std::string to = readable_time(data_.head.measured_to);
    if (from.empty() || to.empty() || from == to) return from.empty() ? to : from;
    const bool one_day =
        from.size() == 20 && to.size() == 20 && from.substr(0, 10) == to.substr(0, 10);
    if (one_day) return fmt::format("{}\u2013{}", from.substr(0, 16), to.substr(11));
    return fmt::format("{} \u2013 {}", from, to);
  }

  void list(
      std::string_view heading, std::string_view kind, const std::vector<std::string>& items) {
    if (items.empty()) return;
    put("<div class=\"{}\">\n<h3>{}</h3>\n<ul>\n", kind, heading);
    for (const std::string& item : items) put("<li>{}</li>\n", escape_html(item));
    put("</ul>\n</div>\n");
  }

  [[nodiscard]] Opening opening() const {
    const OpeningList against{
        "What speaks against the data", "cautions", warning_lines(data_.warnings)};
    if (data_.opening) {
      Opening out = *data_.opening;
      out.lists.insert(out.lists.begin(), against);
      return out;
    }
    const Verdict v = verdict(data_);
    Opening out{.subject = "State of the robot", .title = v.title, .headline = v.headline};
    out.mood = mood_name(v.mood);
    out.decision = v.decision;
    if (v.state != CalibrationState::kUnknown && v.state != CalibrationState::kNotCalibrated) {
      out.before_mm = v.before_mm;
      out.after_mm = v.after_mm;
      out.basis = fmt::format(
          "mean {} before and after, {}", v.by_tool_shift ? "tool shift" : "position error",
          v.basis);
    }
    out.lists.push_back(against);
    out.lists.insert(out.lists.end(), data_.also.begin(), data_.also.end());
    out.lists.push_back({"What to do", "to_do", v.to_do});
    out.lists.push_back({"How far to trust it", "cautions", v.cautions});
    out.lists.push_back({"What could not be judged", "not_judged", v.not_judged});
    return out;
  }

  void state() {
    const Opening box = opening();
    put("<section class=\"state {}\" id=\"state\">\n<h2>{}: <span "
        "class=\"verdict\">{}</span></h2>\n",
        box.mood, escape_html(box.subject), escape_html(box.title));
    if (box.before_mm && box.after_mm) {
      const int decimals = *box.after_mm < 0.02 ? 4 : 3;
      put("<div class=\"big\">\n<p class=\"numbers\"><span class=\"before\">{}</span><span "
          "class=\"to\" aria-label=\"became\">\u2192</span><span class=\"after\">{}</span> "
          "<span class=\"unit\">mm</span></p>\n<p class=\"basis\">{}</p>\n</div>\n",
          fixed(*box.before_mm, decimals), fixed(*box.after_mm, decimals),
          escape_html(box.basis));
    }
    put("<p class=\"headline\">{}</p>\n", escape_html(box.headline));
    if (!box.decision.empty()) {
      put("<p class=\"decision\">{}</p>\n", escape_html(box.decision));
    }
    put("<div class=\"words\">\n");
    for (const OpeningList& each : box.lists) list(each.heading, each.kind, each.lines);
    put("</div>\n</section>\n");
    if (!with_charts_) {
      put("<p class=\"note\" id=\"no_charts\">{} Figures are given as tables only; all numbers "
          "are here.</p>\n",
          has_chart_libraries() ? "This report was made without charts."
                                : "This copy of Sixdial was built without its chart libraries "
                                  "(npm was not available then).");
    }
  }

  /// What stands where. Gives the sections their ids, before any table can take one.
  void contents(const std::vector<Section>& sections) {
    if (sections.empty()) return;
    put("<nav class=\"contents\" id=\"contents\">\n<h2>Contents</h2>\n<ol>\n");
    int number = 0;
    bool annex = false;
    for (const Section& s : sections) {
      if (s.in_annex && !annex) {
        annex = true;
        number = 0;
        put("</ol>\n<h3><a href=\"#annex\">Annex</a></h3>\n<ol>\n");
      }
      section_ids_.push_back(new_id(s.id));
      put("<li><span class=\"number\">{}{}</span> <a href=\"#{}\">{}</a></li>\n",
          s.in_annex ? "A" : "", ++number, section_ids_.back(), escape_html(s.heading));
    }
    put("</ol>\n</nav>\n");
  }

  void section(const Section& s, const std::string& id) {
    put("<section id=\"{}\">\n<h2><span class=\"number\">{}{}</span> {}</h2>\n", id,
        s.in_annex ? "A" : "", ++number_, escape_html(s.heading));
    for (const Block& block : s.blocks) {
      if (const auto* words = std::get_if<std::string>(&block)) {
        put("<p>{}</p>\n", escape_html(*words));
      } else if (const auto* t = std::get_if<Table>(&block)) {
        table(*t, fmt::format("Table {}", ++tables_), "table");
      } else if (const auto* drawn = std::get_if<Picture>(&block)) {
        put("<figure class=\"picture\" id=\"{}\">\n{}<figcaption>\n<p class=\"figure-title\">"
            "<b>Figure {}</b> {}</p>\n<dl>\n<dt>Shows</dt><dd>{}</dd>\n</dl>\n</figcaption>\n"
            "</figure>\n",
            new_id("picture_" + drawn->id), drawn->svg, ++figures_, escape_html(drawn->title),
            escape_html(drawn->shows));
      } else {
        figure(std::get<Figure>(block));
      }
    }
    put("</section>\n");
  }

  static bool is_numeric(const Table& t, std::size_t column) {
    bool any = false;
    for (const auto& row : t.rows) {
      if (column >= row.size()) continue;
      if (std::holds_alternative<std::string>(row[column])) return false;
      any = any || std::holds_alternative<Number>(row[column]);
    }
    return any || !t.columns[column].unit.empty();  // a measure that no row has
  }

  void column_heads(const Table& t, const std::vector<bool>& numeric) {
    const bool grouped = std::any_of(
        t.columns.begin(), t.columns.end(), [](const Column& c) { return !c.group.empty(); });
    const auto heading = [](const Column& c) {
      return escape_html(c.title) +
             (c.unit.empty() ? ""
                             : " <span class=\"unit\">[" + escape_html(c.unit) + "]</span>");
    };
    put("<thead>\n<tr>");
    for (std::size_t i = 0; i < t.columns.size();) {
      const Column& c = t.columns[i];
      if (c.group.empty()) {
        put("<th scope=\"col\"{}{}>{}</th>", grouped ? " rowspan=\"2\"" : "",
            numeric[i] ? " class=\"n\"" : "", heading(c));
        ++i;
        continue;
      }
      std::size_t end = i;
      while (end < t.columns.size() && t.columns[end].group == c.group) ++end;
      put("<th scope=\"colgroup\" colspan=\"{}\" class=\"group\">{}</th>", end - i,
          escape_html(c.group));
      i = end;
    }
    put("</tr>\n");
    if (grouped) {
      put("<tr>");
      for (std::size_t i = 0; i < t.columns.size(); ++i) {
        if (t.columns[i].group.empty()) continue;
        const bool first = i == 0 || t.columns[i - 1].group != t.columns[i].group;
        put("<th scope=\"col\" class=\"{}{}\">{}</th>", numeric[i] ? "n" : "",
            first ? " first" : "", heading(t.columns[i]));
      }
      put("</tr>\n");
    }
    put("</thead>\n");
  }

  void table(const Table& t, const std::string& title, std::string_view kind) {
    const std::size_t rows =
        t.rows.size() <= t.rows_on_page ? t.rows.size() : (t.rows_on_page + 1) / 2;
    std::vector<bool> numeric(t.columns.size());
    for (std::size_t i = 0; i < numeric.size(); ++i) numeric[i] = is_numeric(t, i);
    const bool few = t.columns.size() <= 3;
    const bool narrow = few && rows <= 20 && t.notes.empty();
    put("<div class=\"{}{}{}\" id=\"{}\">\n<table>\n<caption>{}{}</caption>\n", kind,
        rows > 40 ? " long" : "",
        narrow ? " few narrow"
        : few  ? " few"
               : "",
        new_id(t.id), title.empty() ? "" : "<b>" + escape_html(title) + "</b> ",
        escape_html(t.caption));
    column_heads(t, numeric);
    put("<tbody>\n");
    for (std::size_t r = 0; r < rows; ++r) {
      put("<tr{}>", t.main_row == r ? " class=\"main\"" : "");
      for (std::size_t c = 0; c < t.rows[r].size() && c < t.columns.size(); ++c) {
        const bool first = c > 0 && !t.columns[c].group.empty() &&
                           t.columns[c - 1].group != t.columns[c].group;
        const std::string_view kinds[] = {
            "", " class=\"n\"", " class=\"first\"", " class=\"n first\""};
        put("<td{}>{}</td>", kinds[(numeric[c] ? 1U : 0U) + (first ? 2U : 0U)],
            escape_html(shown(t.rows[r][c])));
      }
      put("</tr>\n");
    }
    put("</tbody>\n</table>\n");
    for (const std::string& note : t.notes)
      put("<p class=\"note\">{}</p>\n", escape_html(note));
    if (rows < t.rows.size()) {
      put("<p class=\"note\">The first {} of {} rows; the CSV and JSON forms of this report "
          "have all.</p>\n",
          rows, t.rows.size());
    }
    put("</div>\n");
  }

  void figure(const Figure& f) {
    const std::string id = new_id("figure_" + f.id);
    put("<figure id=\"{}\">\n", id);
    if (with_charts_) {
      put("<div class=\"chart\" data-chart=\"{}\"></div>\n", id);
      charts_[id] = chart_json(f.chart, marks_);
    }
    put("<figcaption>\n<p class=\"figure-title\"><b>Figure {}</b> {}</p>\n<dl>\n", ++figures_,
        escape_html(f.title));
    put("<dt>Shows</dt><dd>{}</dd>\n<dt>Good</dt><dd>{}</dd>\n<dt>Here</dt><dd>{}</dd>\n</"
        "dl>\n",
        escape_html(f.shows), escape_html(f.good),
        f.here.empty() ? "nothing to say in a sentence" : escape_html(f.here));
    if (is_thinned(f.chart, marks_)) {
      put("<p class=\"note\">Too many to draw all: an even choice of each series is "
          "shown.</p>\n");
    }
    put("</figcaption>\n");
    // Open, so that it is read where no script runs; charts.js closes it once the chart is
    // drawn.
    put("<details open>\n<summary>The numbers of figure {}</summary>\n", figures_);
    table(f.table, "", "table");
    put("</details>\n</figure>\n");
  }

  void foot() {
    put("<footer>\n<p>Made by Sixdial {} from session <bdi>{}</bdi>, data <span "
        "class=\"hash\">{}</span>. Residuals are measured minus modelled; lengths in mm, "
        "angles as headed; times in UTC; frame: the table (WCS). Not an accredited "
        "certificate.</p>\n",
        escape_html(data_.head.software_version), escape_html(data_.head.session_name),
        escape_html(data_.head.data_hash));
    put("</footer>\n");
  }

  void scripts() {
    if (!with_charts_) return;
    put("<script type=\"application/json\" id=\"charts\">{}</script>\n",
        escape_script(charts_.dump()));
    put("<script>\n/*\n{}*/\n{}</script>\n<script>\n{}</script>\n", assets::licences(),
        assets::d3_js(), assets::plot_js());
    put("<script>\n{}</script>\n", assets::chart_script());
  }

  const ReportData& data_;
  const bool with_charts_;
  nlohmann::json charts_;
  std::size_t marks_ = kMarksOnChart;  // of one chart
  std::string out_;
  std::vector<std::string> section_ids_;
  std::map<std::string, int> ids_{
      {"state", 1}, {"charts", 1}, {"no_charts", 1}, {"contents", 1}, {"annex", 1}};
  int number_ = 0, tables_ = 0, figures_ = 0;
};

}  // namespace

bool has_chart_libraries() { return !assets::d3_js().empty() && !assets::plot_js().empty(); }

std::string html_report(const ReportData& data, const HtmlOptions& options) {
  return Page{data, options.charts && has_chart_libraries()}.text();
}

}  // namespace sixdial::report
