// Any bytes as session.csv or as a plan: an error with a place, or a session that is written
// back with the same bytes.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "session/bundle.h"
#include "session/plan.h"
#include "session/rig_file.h"

namespace {

using namespace sixdial::session;

void expect(bool law) {
  if (!law) std::abort();
}

void check_place(const DataError& error) {
  expect(!error.mistakes.empty());
  expect(error.line >= 1 && error.column >= 1);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string rig_text = write_rig(sixdial::geometry::default_rig());
  static const sixdial::geometry::Rig rig = sixdial::geometry::default_rig();
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const Session session = parse_session(text, "session.csv", rig_text, "rig.toml");
    expect(session_csv(session) == text);
  } catch (const DataError& error) {
    check_place(error);
    try {
      const Session rest = parse_session(
          text, "session.csv", rig_text, "rig.toml", {.skip_bad_rows = true, .name = "rest"});
      expect(!rest.rejected.empty());
      const Session again =
          parse_session(session_csv(rest), "session.csv", rig_text, "rig.toml");
      expect(again.samples.size() == rest.samples.size());
    } catch (const DataError& second) {
      check_place(second);
    }
  }
  try {
    const Plan plan = parse_plan(text, "plan.csv", rig);
    expect(
        parse_plan(plan_csv(plan, layout_of(rig)), "plan.csv", rig).points.size() ==
        plan.points.size());
  } catch (const DataError& error) {
    check_place(error);
  }
  return 0;
}
