#include "report/causes_doc.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "diagnosis/readings.h"
#include "geometry/rig.h"
#include "geometry/units.h"
#include "report/words/diagnosis_words.h"
#include "simulation/effect.h"

namespace sixdial::report {
namespace {

using diagnosis::Readings;
using simulation::ActiveEffect;
using simulation::Effect;
using simulation::Place;

constexpr double kShownTimes = 3.0;  // of the plausible size: what the pictures' sessions have
constexpr double kVisible_mm =
    0.002;                      // and at least so much left after the fit: a dial's noise
constexpr double kAlike = 0.5;  // cosine from which two signatures are called alike
constexpr std::size_t kMostNeighbours = 3;
constexpr int kAcross = 12;  // poses along each side of the rectangle

std::string needs_of(unsigned needs) {
  std::string text;
  const auto add = [&](unsigned bit, const char* words) {
    if ((needs & bit) != 0) text += (text.empty() ? "" : ", ") + std::string(words);
  };
  add(simulation::kTime, "time of each sample");
  add(simulation::kTemperature, "temperature");
  add(simulation::kApproach, "side of approach");
  add(simulation::kDials, "raw readings of the dials");
  return text.empty() ? "nothing but positions" : text;
}

/// A session without noise on the default rig: a grid, both sides of arrival, twenty minutes in
/// which the temperature rises by 3 degC and falls again.
std::vector<simulation::Trial> plain_session(const simulation::ForwardModel& model) {
  const geometry::Rig& rig = model.rig();
  std::vector<simulation::Trial> trials;
  const auto reference = geometry::inverse(
      rig.robot.nominal, rig.cuboid.reference_pose_mm, rig.robot.working_mode);
  for (int i = 0; i < kAcross * kAcross && reference; ++i) {
    const int place = (i * 55) % (kAcross * kAcross);  // 55 has no divisor with 144: no order
    const int column = place % kAcross;
    const int row = place / kAcross;
    const Eigen::Vector2d target_mm(
        16.0 + 24.0 * column / (kAcross - 1.0), 30.0 + 36.0 * row / (kAcross - 1.0));
    const auto q =
        geometry::inverse(rig.robot.nominal, target_mm, rig.robot.working_mode, *reference);
    if (!q) continue;
    simulation::Trial trial;
    trial.sample = trial.point = static_cast<int>(trials.size());
    trial.q = *q;
    trial.time_s = 8.0 * i;
    trial.temperature_c = 20.0 + 3.0 * std::sin(std::numbers::pi * i / (kAcross * kAcross));
    trial.approach = {i % 2 == 0 ? 1 : -1, (i / 2) % 2 == 0 ? 1 : -1};
    const auto seen = model.predict(model.nominal(), trial.q, trial.assembly);
    if (!seen) continue;
    for (std::size_t dial = 0; dial < rig.dials.size(); ++dial) {
      trial.reading.push_back(
          seen->in_contact[dial] ? std::optional(seen->reading[static_cast<Eigen::Index>(dial)])
                                 : std::nullopt);
    }
    trials.push_back(std::move(trial));
  }
  return trials;
}

/// An effect of one size of its first parameter; a searched value from the middle.
ActiveEffect sized(const Readings& readings, const Effect& effect, const Place& place) {
  ActiveEffect active{&effect, place, std::vector<double>(effect.parameters.size(), 0.0)};
  if (effect.searched) {
    const auto values =
        effect.searched(readings.model().rig(), readings.circumstances(), place);
    if (!values.empty()) active.x.back() = values[values.size() / 2];
  }
  if (!active.x.empty()) active.x[0] = parameter_at(effect, place, 0)->sigma;
  return active;
}

/// How an effect shows: in each reading, and as a shift of the tool.
struct Shown {
  Eigen::VectorXd readings_mm;
  double tool_rms_mm = 0.0, tool_max_mm = 0.0;
};

/// The default rig can have it, and it has a form that can be computed.
bool has_picture(const Effect& effect, const geometry::Rig& rig) {
  return !effect.is_curve && !effect.places(rig).empty();
}

class Book {
 public:
  Book() : model_(geometry::default_rig()), readings_(model_, plain_session(model_)) {
    readings_.place_tool(model_.nominal());
    plain_mm_ = readings_.simulate(model_.nominal(), plain_);
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(
        scaled(readings_.jacobian(model_.nominal())));
    fitted_ = qr.householderQ() *
              Eigen::MatrixXd::Identity(plain_mm_.size(), model_.parameter_count());
    for (const Effect* effect : simulation::all_effects()) {
      if (!has_picture(*effect, model_.rig())) continue;
      for (const Place& place : effect->places(model_.rig())) {
        Eigen::MatrixXd columns = signature(*effect, place);
        columns -= fitted_ * (fitted_.transpose() * columns);
        if (columns.norm() > 1e-9) spaces_.push_back({effect, basis(columns)});
      }
    }
  }

  [[nodiscard]] const geometry::Rig& rig() const { return model_.rig(); }

  [[nodiscard]] Shown shown(const Effect& effect, const Place& place) const {
    const ActiveEffect active = sized(readings_, effect, place);
    Shown out;
    out.readings_mm = readings_.simulate(model_.nominal(), plain_, &active) - plain_mm_;
    simulation::Scene with;
    simulation::Scene without;
    int count = 0;
    for (std::size_t t = 0; t < readings_.trials().size(); ++t) {
      const auto& trial = readings_.trials()[t];
      const auto& sample = readings_.circumstances()[t];
      if (!plain_.run(model_.nominal(), trial, sample, without) ||
          !plain_.run(model_.nominal(), trial, sample, with, &active)) {
        continue;
      }
      const double shift_mm = (with.p_WE - without.p_WE).norm();
      out.tool_rms_mm += shift_mm * shift_mm;
      out.tool_max_mm = std::max(out.tool_max_mm, shift_mm);
      ++count;
    }
    if (count > 0) out.tool_rms_mm = std::sqrt(out.tool_rms_mm / count);
    return out;
  }

  /// RMS of what the eleven fitted parameters do not take of it [mm].
  [[nodiscard]] double left_mm(const Shown& shown) const {
    const Eigen::VectorXd left =
        shown.readings_mm - fitted_ * (fitted_.transpose() * shown.readings_mm);
    return left.norm() / std::sqrt(static_cast<double>(left.size()));
  }

  struct Neighbour {
    const Effect* effect;
    double cosine;
  };
  /// The causes that look most like it, each at its likest place.
  [[nodiscard]] std::vector<Neighbour> neighbours(const Effect& effect) const {
    std::vector<Neighbour> out;
    for (const Space& other : spaces_) {
      if (other.effect == &effect) continue;
      double cosine = 0.0;
      for (const Space& mine : spaces_) {
        if (mine.effect != &effect) continue;
        const Eigen::JacobiSVD<Eigen::MatrixXd> svd(mine.basis.transpose() * other.basis);
        cosine = std::max(cosine, svd.singularValues()[0]);
      }
      const auto known = std::ranges::find(out, other.effect, &Neighbour::effect);
      if (known == out.end()) {
        out.push_back({other.effect, cosine});
      } else {
        known->cosine = std::max(known->cosine, cosine);
      }
    }
    std::erase_if(out, [](const Neighbour& each) { return each.cosine < kAlike; });
    std::ranges::stable_sort(out, std::greater{}, &Neighbour::cosine);
    if (out.size() > kMostNeighbours) out.resize(kMostNeighbours);
    return out;
  }

 private:
  struct Space {
    const Effect* effect;
    Eigen::MatrixXd basis;
  };

  static Eigen::MatrixXd scaled(Eigen::MatrixXd columns) {
    for (Eigen::Index i = 0; i < columns.cols(); ++i) {
      const double size = columns.col(i).norm();
      if (size > 0.0) columns.col(i) /= size;
    }
    return columns;
  }
  static Eigen::MatrixXd basis(const Eigen::MatrixXd& columns) {
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(scaled(columns), Eigen::ComputeThinU);
    Eigen::Index rank = 0;
    while (rank < svd.singularValues().size() &&
           svd.singularValues()[rank] > 1e-6 * svd.singularValues()[0]) {
      ++rank;
    }
    return svd.matrixU().leftCols(rank);
  }

  /// A column for each linear parameter at its plausible size; one for those without any.
  [[nodiscard]] Eigen::MatrixXd signature(const Effect& effect, const Place& place) const {
    ActiveEffect active = sized(readings_, effect, place);
    const auto linear =
        static_cast<Eigen::Index>(effect.parameters.size()) - (effect.searched ? 1 : 0);
    Eigen::MatrixXd columns(plain_mm_.size(), std::max<Eigen::Index>(1, linear));
    for (Eigen::Index k = 0; k < columns.cols(); ++k) {
      if (!active.x.empty()) {
        for (Eigen::Index j = 0; j < linear; ++j) {
          const auto parameter = parameter_at(effect, place, static_cast<int>(j));
          const double size = parameter ? parameter->sigma : 0.0;
          active.x[static_cast<std::size_t>(j)] = j == k ? size : 0.0;
        }
      }
      columns.col(k) = readings_.simulate(model_.nominal(), plain_, &active) - plain_mm_;
    }
    return columns;
  }

  simulation::ForwardModel model_;
  simulation::ExtendedModel plain_{model_, {}};
  Readings readings_;
  Eigen::VectorXd plain_mm_;
  Eigen::MatrixXd fitted_;
  std::vector<Space> spaces_;
};

std::string size_words(const Effect& effect, const Place& place) {
  std::string sizes;
  for (int k = 0; k < static_cast<int>(effect.parameters.size()); ++k) {
    const auto each = parameter_at(effect, place, k);
    const bool is_sample =
        effect.is_step && k + 1 == static_cast<int>(effect.parameters.size());
    if (!each || is_sample) continue;  // a step may come at any sample
    sizes += fmt::format(
        "{}{} {:g}{}{}", sizes.empty() ? "" : ", ", each->name, each->sigma,
        each->unit == "1" ? "" : " ", each->unit == "1" ? "" : each->unit);
    if (each->unit == "rad")
      sizes += fmt::format(" ({:.2g}\u00B0)", geometry::kDegPerRad * each->sigma);
  }
  return sizes.empty() ? "no number: it is so or not" : sizes;
}

std::string on_parts(const Book& book, const Shown& shown) {
  const double readings_mm =
      shown.readings_mm.norm() / std::sqrt(static_cast<double>(shown.readings_mm.size()));
  std::string words =
      shown.tool_max_mm > 1e-6
          ? fmt::format(
                "the tool stands {:.2g} mm (rms), at most {:.2g} mm from where it should",
                shown.tool_rms_mm, shown.tool_max_mm)
          : fmt::format(
                "the tool does not move; readings are off by up to {:.2g} mm",
                shown.readings_mm.cwiseAbs().maxCoeff());
  const double left_mm = book.left_mm(shown);
  words += fmt::format(
      "; fitted parameters hide {:.0f} % of it, {:.2g} mm (rms) is left in the readings",
      100.0 * (1.0 - left_mm / readings_mm), left_mm);
  return words;
}

std::string neighbour_words(const Book& book, const Effect& effect) {
  std::string words;
  for (const Book::Neighbour& each : book.neighbours(effect)) {
    words += fmt::format(
        "{}[{}](#{}) {:.0f} %", words.empty() ? "" : ", ", each.effect->in_words,
        each.effect->cause, 100.0 * each.cosine);
  }
  return words.empty() ? "none by more than 50 %" : words;
}

const Place& shown_place(const Effect& effect, const std::vector<Place>& places) {
  // Where the places differ in kind, the first.
  return effect.plot_of_place ? places.front() : places[places.size() / 2];
}

/// The session of the picture, as `sixdial-mock-rig --hide` takes it.
std::string hidden(const Book& book, const Effect& effect, const Place& place) {
  std::string text = fmt::format("{}:{}", effect.cause, place.name);
  if (!effect.parameters.empty()) {
    const double times =
        std::max(kShownTimes, std::ceil(kVisible_mm / book.left_mm(book.shown(effect, place))));
    text += fmt::format(":{:g}", times * parameter_at(effect, place, 0)->sigma);
  }
  return text;
}

/// Curves of any form, and what only other robots and instruments than the default rig's have.
std::string effects_without_picture(const geometry::Rig& rig) {
  std::string page =
      "\n## Curves, and other robots and instruments\n\nA curve has no form of its own to be "
      "drawn; the others are looked for in robots that work in space, or where another "
      "instrument than dials on a cuboid measures.\n";
  for (const Effect* effect : simulation::all_effects()) {
    if (has_picture(*effect, rig)) continue;
    page += fmt::format(
        "\n<a id=\"{0}\"></a>\n\n### {1} (`{0}`)\n\n| | |\n|---|---|\n| how it shows | {2} |\n"
        "| effect on parts | {3} |\n| what to do | {4} |\n| told apart | {5} |\n"
        "| poses that help | {6} |\n| needs | {7} |\n",
        effect->cause, effect->in_words, effect->signature, effect->consequence, effect->advice,
        effect->told_apart, effect->helps, needs_of(effect->needs));
  }
  return page;
}

/// What a diagnosis can find besides: it has no formula that would be searched for.
std::string findings_without_effect() {
  constexpr std::array kKinds{
      std::pair{studies::CauseKind::kRigGeometry, "rig_geometry"},
      std::pair{studies::CauseKind::kOutliers, "outliers"},
      std::pair{studies::CauseKind::kStaleReadings, "stale_reading"}};
  std::string page =
      "\n## Findings without a formula\n\nThese are named as well. They have no shape that is "
      "known beforehand, so none is searched for.\n";
  for (const auto& [kind, cause] : kKinds) {
    const CauseTexts texts = texts_of(studies::FoundCause{.kind = kind});
    page += fmt::format(
        "\n<a id=\"{0}\"></a>\n\n### {1} (`{0}`)\n\n| | |\n|---|---|\n| how it shows | {2} |\n"
        "| effect on parts | {3} |\n| what to do | {4} |\n",
        cause, kind_in_words(kind), texts.signature, texts.consequence, texts.advice);
  }
  return page;
}

}  // namespace

std::string causes_markdown() {
  const Book book;
  std::string page =
      "# The causes, one by one\n\n<!-- Printed by `sixdiald --print-causes` from "
      "simulation/effects/; a test compares. Pictures: scripts/cause_pictures.py -->\n\n"
      "Each physical effect of the catalogue. The picture is the signature that `sixdial "
      "diagnose` found in a simulated session of 150 points with noise of 0.002 mm, which the "
      "command under it makes again; the effect there is three times its plausible size. "
      "Points "
      "are measured, the line or the triangles are the cause as fitted.\n\n"
      "*Plausible size* is what the search begins with on a rig of this kind. *At that size* "
      "is "
      "computed with the default rig on a grid of 144 poses: what the tool does, and how much "
      "of "
      "the effect the fit of the robot's parameters swallows, so that nobody sees it. *Looks "
      "like* gives the causes whose signature points the same way after that fit (100 %: "
      "nothing on these poses tells them apart; at their likest place).\n";
  for (const Effect* effect : simulation::all_effects()) {
    if (!has_picture(*effect, book.rig())) continue;
    const std::vector<Place> places = effect->places(book.rig());
    const Place& place = shown_place(*effect, places);
    page += fmt::format(
        "\n<a id=\"{}\"></a>\n\n## {} (`{}`)\n\n", effect->cause, effect->in_words,
        effect->cause);
    page += fmt::format(
        "![Signature of {}](../pictures/causes/{}.svg)\n\n`sixdial-mock-rig --bundle {} --hide "
        "{} --seed 5`, `sixdial diagnose {}/`\n\n| | |\n|---|---|\n",
        effect->in_words, effect->cause, effect->cause, hidden(book, *effect, place),
        effect->cause);
    page += fmt::format("| how it shows | {} |\n", effect->signature);
    page += fmt::format("| plausible size | {} |\n", size_words(*effect, place));
    page += fmt::format("| at that size | {} |\n", on_parts(book, book.shown(*effect, place)));
    page += fmt::format("| effect on parts | {} |\n", effect->consequence);
    page += fmt::format("| what to do | {} |\n", effect->advice);
    page += fmt::format("| looks like | {} |\n", neighbour_words(book, *effect));
    page += fmt::format("| told apart | {} |\n", effect->told_apart);
    page += fmt::format("| poses that help | {} |\n", effect->helps);
    page += fmt::format("| needs | {} |\n", needs_of(effect->needs));
    std::string names;
    for (const Place& each : places) {
      names += (names.empty() ? "" : ", ") + each.name;
    }
    page += fmt::format("| looked for at | {} |\n", names);
    if (!effect->why_not_learned.empty()) {
      page += fmt::format("| and the network? | {} |\n", effect->why_not_learned);
    }
  }
  return page + effects_without_picture(book.rig()) + findings_without_effect();
}

}  // namespace sixdial::report
