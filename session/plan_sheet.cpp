#include "session/plan_sheet.h"

#include <fmt/format.h>

#include <optional>
#include <vector>

#include "geometry/units.h"
#include "session/csv.h"

namespace sixdial::session {
namespace {

/// How a joint's value stands on paper.
struct PaperColumn {
  std::string name;
  double per_unit = 1.0;  // of the value inside [rad or mm]
};

std::vector<PaperColumn> paper_columns(const SampleLayout& layout) {
  std::vector<PaperColumn> columns;
  for (const Joint& joint : layout.joints) {
    if (joint.degrees_too) {
      columns.push_back({joint.name + "_deg", geometry::kDegPerRad});
    } else {
      columns.push_back({joint.column()});
    }
  }
  return columns;
}

std::string first_columns(const SampleLayout& layout) {
  return layout.sockets.empty() ? "set,point,repeat" : "set,point,repeat,socket";
}

std::string first_fields(const PlanPoint& point, const SampleLayout& layout) {
  std::string out = fmt::format("{},{},{}", csv_field(point.set), point.point, point.repeat);
  if (!layout.sockets.empty()) out += ',' + csv_field(point.socket);
  return out;
}

/// Digits behind the point of a joint value; empty: no value.
std::string sheet(const Plan& plan, const geometry::Rig& rig, std::optional<int> digits) {
  const SampleLayout layout = layout_of(rig);
  const std::vector<PaperColumn> columns = paper_columns(layout);
  std::string out = first_columns(layout);
  for (const PaperColumn& each : columns) out += ',' + csv_field(each.name);
  for (const PlanPoint& point : plan.points) {
    out += '\n' + first_fields(point, layout);
    for (std::size_t k = 0; k < columns.size(); ++k) {
      out += ',';
      if (!digits) continue;
      const double value = point.q[static_cast<Eigen::Index>(k)] * columns[k].per_unit;
      out += fmt::format("{:.{}f}", value, *digits);
    }
  }
  return out + '\n';
}

}  // namespace

std::string pose_sheet(const Plan& plan, const geometry::Rig& rig) {
  constexpr int kDigits = 2;
  return sheet(plan, rig, kDigits);
}

std::string empty_session(const Plan& plan, const geometry::Rig& rig) {
  return sheet(plan, rig, std::nullopt);
}

std::string filled_session(const Plan& plan, const geometry::Rig& rig) {
  constexpr int kDigits = 4;
  return sheet(plan, rig, kDigits);
}

}  // namespace sixdial::session
