// sixdial compensate: the joint values to command, for a target or a plan.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cli/cli.h"
#include "cli/local_run.h"
#include "cli/shared_options.h"
#include "report/documents/calibration_json.h"
#include "report/documents/compensation_json.h"
#include "report/documents/diagnosis_json.h"
#include "report/documents/outside_json.h"
#include "report/documents/warnings_document.h"
#include "report/words/compensation_words.h"
#include "report/words/warning_words.h"
#include "session/csv.h"
#include "studies/calibrate.h"
#include "studies/compensate.h"
#include "studies/diagnose.h"
#include "studies/extended_command.h"
#include "studies/recommendation.h"
#include "studies/stored_warnings.h"

namespace sixdial::cli {
namespace {

struct CompensateOptions {
  std::string calibration_method{studies::kPaperMethod};
  std::string subject, plan_file, output, result_file, diagnosis_file, by = "recommended", mode;
  std::vector<double> target;  // x, y or x, y, z [mm], then rx, ry, rz [deg]
  std::vector<int> approach;
  std::optional<double> temperature_c;
  std::int64_t result = 0, diagnosis = 0;
  std::uint64_t seed = 1;
  bool skip_bad_rows = false;
  bool from_other_session = false;
};

constexpr std::string_view kOtherSession =
    "Use one of this session, or say --from-other-session where the robot is the same.";

constexpr std::string_view kNominal =
    "The nominal robot commands: these are its own joint values, nothing is compensated. Which "
    "model does better, if one does: sixdial recommend SESSION.";

/// "30,45" as numbers.
std::vector<double> figures_of(const std::string& option, const std::string& text) {
  std::vector<double> figures;
  std::size_t from = 0;
  while (from <= text.size()) {
    const std::size_t end = std::min(text.find(',', from), text.size());
    const std::string part = text.substr(from, end - from);
    const session::ParsedNumber parsed = session::parse_number(part);
    if (parsed.trouble) {
      throw CLI::ValidationError(
          option, "'" + part + "' of '" + text + "' is no number; separate numbers by commas");
    }
    figures.push_back(parsed.value);
    from = end + 1;
  }
  return figures;
}

/// What speaks against the data, and what of the answer was not measured.
void tell_warnings(Cli& cli, const Json& answer) {
  if (cli.console.json) return;
  for (const std::string& line : report::warning_lines(report::warnings_in(answer))) {
    cli.console.warn(line);
  }
  const Json outside = answer.value("outside_measured", Json::object());
  const auto words = outside.value("words", std::string());
  if (!words.empty()) cli.console.warn(words);
  if (answer.value("by", "") == studies::to_string(studies::CompensateBy::kBefore)) {
    cli.console.warn(std::string(kNominal));
  }
}

/// The document of a target, with what speaks against the data.
Json with_warnings(Json document, const std::vector<studies::Warning>& warnings) {
  document["warnings"] = report::warnings_json(warnings);
  return document;
}

/// As the service's answers say it.
Json with_outside(
    Json answer, const session::Session& session, const geometry::Position& target_mm,
    geometry::WorkingMode mode) {
  answer["outside_measured"] = report::outside_json(
      studies::outside_measured(studies::measured_area(session), target_mm, mode), 1);
  return answer;
}
Json outside_of_plan(const session::Session& session, const session::Plan& asked) {
  return report::outside_json(
      studies::outside_measured(studies::measured_area(session), asked, session.rig),
      asked.points.size());
}

/// `answer`: the document, as the service gave it or made here.
void print_target(Cli& cli, const Json& answer) {
  tell_warnings(cli, answer);
  cli.console.print(
      "compensation", answer,
      report::compensation_text(report::commanded_target_from_json(answer)));
}

/// `by`: what it was solved by.
void print_plan(
    Cli& cli, const CompensateOptions& options, std::string_view by, std::size_t points,
    const std::string& text, const Json& warnings, const Json& outside) {
  tell_warnings(cli, {{"by", by}, {"warnings", warnings}, {"outside_measured", outside}});
  if (!options.output.empty()) session::write_file(options.output, text);
  if (cli.console.json) {
    Json answer{
        {"points", points}, {"by", by}, {"warnings", warnings}, {"outside_measured", outside}};
    answer[options.output.empty() ? "plan_csv" : "file"] =
        options.output.empty() ? text : options.output;
    cli.console.print_json("plan", answer);
  } else if (options.output.empty()) {
    cli.console.print_data(text);
  } else {
    cli.console.note(fmt::format("{} points in {}", points, options.output));
  }
}

using Warnings = std::vector<studies::Warning>;

/// Refuses to command by data that contradict themselves. Gives the working mode that commands
/// are for unless another is asked for.
geometry::WorkingMode commanded_mode(const Warnings& warnings, const geometry::Rig& rig) {
  report::check_may_command(warnings);
  return studies::working_mode_in_use(warnings, rig);
}

/// What is asked of a session, refused before minutes go into a fit. Empty: a plan is, which is
/// read again by what commands.
std::optional<studies::GivenTarget> asked_target(
    const CompensateOptions& options, const session::Session& session) {
  studies::check_sides(*session.rig.robot.model, options.approach.size());
  if (options.plan_file.empty()) return studies::given_target(session, options.target);
  if (options.result_file.empty() && options.diagnosis_file.empty()) {
    studies::check_commands_turns(
        session,
        studies::read_plan(options.plan_file, session.rig, studies::rig_of_turns(session)));
  }
  return std::nullopt;
}

/// With the extended model of a diagnosis that is made now or read. `given`: unless a plan is.
service::ExitCode extend_bundle(
    Cli& cli, const CompensateOptions& options, session::Session session,
    studies::CompensateBy by, const std::optional<studies::GivenTarget>& given) {
  studies::DiagnosisResult diagnosis;
  if (options.diagnosis_file.empty()) {
    studies::DiagnosisRequest request;
    request.seed = options.seed;
    request.bootstrap = 0;
    request.with_gain = by == studies::CompensateBy::kExtendedFull;  // trains what it needs
    diagnosis = made_first(
        cli.console, "the diagnosis", "--diagnosis-file",
        [&](const auto& progress, std::stop_token stop) {
          return studies::diagnose(session, request, progress, std::move(stop));
        });
  } else {
    diagnosis = report::diagnosis_from_json(read_document(options.diagnosis_file));
    if (!options.from_other_session) {
      studies::check_same_data(diagnosis.inputs, session, "diagnosis", kOtherSession);
    }
    studies::judge_stored(diagnosis, session);
  }
  const Warnings warnings = diagnosis.warnings.value_or(Warnings());
  session.rig.robot.working_mode = commanded_mode(warnings, session.rig);
  const studies::ExtendedCommand command(diagnosis.extended_fit, session.rig, by);
  if (!given) {
    const session::Plan asked = studies::read_plan(
        options.plan_file, session.rig,
        studies::rig_of_turns(session.rig, command.without_causes()));
    studies::check_commands_turns(session, asked);
    if (studies::asks_turns(asked)) studies::check_knows_turns(diagnosis.extended_fit);
    const session::Plan plan = studies::extended_plan(
        asked, command, session.rig, {.temperature_c = options.temperature_c});
    print_plan(
        cli, options, studies::to_string(by), plan.points.size(),
        session::plan_csv(plan, session::layout_of(session.rig)),
        report::warnings_json(warnings), outside_of_plan(session, asked));
    return service::ExitCode::kOk;
  }
  const geometry::WorkingMode mode =
      geometry::working_mode_from(options.mode).value_or(session.rig.robot.working_mode);
  if (given->turn) studies::check_knows_turns(diagnosis.extended_fit);
  const studies::CommandMoment moment{
      .approach = options.approach, .temperature_c = options.temperature_c};
  studies::CommandedTarget commanded = studies::commanded_target(
      command.solve(given->target(), mode, moment), by, *given, mode, *session.rig.robot.model);
  commanded.uncertainty = command.uncertainty(commanded, moment);
  print_target(
      cli,
      with_outside(
          with_warnings(report::to_json(commanded), warnings), session, given->p_mm, mode));
  return service::ExitCode::kOk;
}

/// Made now, or read from a result file.
studies::CalibrationResult calibration_of(
    Cli& cli, const CompensateOptions& options, const session::Session& session) {
  if (!options.result_file.empty()) {
    studies::CalibrationResult stored =
        report::calibration_from_json(read_document(options.result_file));
    if (!options.from_other_session) {
      studies::check_same_data(stored.inputs, session, "calibration", kOtherSession);
    }
    studies::judge_stored(stored, session);
    return stored;
  }
  studies::CalibrationRequest request;
  request.seed = options.seed;
  request.method = options.calibration_method;
  return made_first(
      cli.console, "the calibration", "--calibration",
      [&](const auto& progress, std::stop_token stop) {
        return studies::calibrate(session, request, progress, std::move(stop));
      });
}

/// By the calibration, and by the causes of a diagnosis that is given.
studies::CompensateBy recommended_of(
    const studies::CalibrationResult& calibration, const CompensateOptions& options) {
  if (options.diagnosis_file.empty()) return studies::recommend(calibration).by;
  const studies::DiagnosisResult diagnosis =
      report::diagnosis_from_json(read_document(options.diagnosis_file));
  return studies::recommend(calibration, &diagnosis).by;
}

service::ExitCode compensate_bundle(Cli& cli, const CompensateOptions& options) {
  session::Session session =
      read_bundle_with_warnings(cli, options.subject, options.skip_bad_rows);
  const std::optional<studies::GivenTarget> given = asked_target(options, session);
  const std::optional<studies::CompensateBy> asked = studies::compensate_by_from(options.by);
  if (asked && is_extended(*asked)) {
    return extend_bundle(cli, options, std::move(session), *asked, given);
  }
  const studies::CalibrationResult calibrated = calibration_of(cli, options, session);
  const studies::CompensateBy by = asked ? *asked : recommended_of(calibrated, options);
  if (is_extended(by)) return extend_bundle(cli, options, std::move(session), by, given);
  const Warnings warnings = calibrated.warnings.value_or(Warnings());
  session.rig.robot.working_mode = commanded_mode(warnings, session.rig);
  const calibration::CompensationModel model =
      studies::compensation_model(calibrated, session.rig, by);
  if (!given) {
    const session::Plan planned = studies::read_plan(
        options.plan_file, session.rig, studies::rig_of_turns(session.rig, model));
    studies::check_commands_turns(session, planned);
    if (studies::asks_turns(planned)) studies::check_knows_turns(calibrated, by, session);
    const session::Plan plan = studies::compensated_plan(planned, model, session.rig);
    print_plan(
        cli, options, studies::to_string(by), plan.points.size(),
        session::plan_csv(plan, session::layout_of(session.rig)),
        report::warnings_json(warnings), outside_of_plan(session, planned));
    return service::ExitCode::kOk;
  }
  const geometry::WorkingMode mode =
      geometry::working_mode_from(options.mode).value_or(session.rig.robot.working_mode);
  if (given->turn) studies::check_knows_turns(calibrated, by, session);
  studies::CommandedTarget commanded = studies::compensated_target(model, by, *given, mode);
  commanded.uncertainty = studies::target_uncertainty(calibrated, session.rig, commanded);
  print_target(
      cli,
      with_outside(
          with_warnings(report::to_json(commanded), warnings), session, given->p_mm, mode));
  return service::ExitCode::kOk;
}

service::ExitCode compensate_session(Cli& cli, const CompensateOptions& options) {
  Json params{{"session", options.subject}, {"by", options.by}};
  if (options.result > 0) params["result"] = options.result;
  if (options.diagnosis > 0) params["diagnosis"] = options.diagnosis;
  if (options.from_other_session) params["from_other_session"] = true;
  if (options.temperature_c) params["temperature_c"] = *options.temperature_c;
  if (options.plan_file.empty()) {
    for (std::size_t joint = 0; joint < options.approach.size(); ++joint) {
      params[fmt::format("approach{}", joint + 1)] = options.approach[joint];
    }
    if (options.target.size() != 2 && options.target.size() != 3) {
      throw studies::StudyError(
          studies::StudyErrorCode::kInvalidParams,
          fmt::format(
              "a target of {} figures, of a session of the service", options.target.size()),
          {{"param", "target"}},
          "Give x,y or x,y,z in mm. The service keeps no turns of the tool: for x,y,z,rx,ry,rz "
          "give the session's folder.");
    }
    params["x_mm"] = options.target[0];
    params["y_mm"] = options.target[1];
    if (options.target.size() == 3) params["z_mm"] = options.target[2];
    if (!options.mode.empty()) params["mode"] = options.mode;
    print_target(cli, cli.call("compensate.target", params));
    return service::ExitCode::kOk;
  }
  params["plan_csv"] = session::read_file(options.plan_file);
  if (options.output.empty()) {
    const Json answer = cli.call("compensate.plan", params);
    print_plan(
        cli, options, answer["by"].get<std::string>(), answer["points"].get<std::size_t>(),
        answer["plan_csv"].get<std::string>(), answer["warnings"], answer["outside_measured"]);
    return service::ExitCode::kOk;
  }
  params["path"] = absolute(options.output);
  const Json answer = cli.call("compensate.plan", params);
  tell_warnings(cli, answer);
  cli.console.print(
      "plan",
      {{"points", answer["points"]},
       {"by", answer["by"]},
       {"file", options.output},
       {"warnings", answer["warnings"]},
       {"outside_measured", answer["outside_measured"]}},
      "");
  if (!cli.console.json) {
    cli.console.note(fmt::format("{} points in {}", answer["points"].dump(), options.output));
  }
  return service::ExitCode::kOk;
}

/// "--target x,y" in the plane, x,y,z in space, with rx,ry,rz where turns are commanded.
CLI::Option* add_target(CLI::App& command, const std::shared_ptr<CompensateOptions>& options) {
  return command
      .add_option_function<std::string>(
          "--target",
          [options](const std::string& text) {
            options->target = figures_of("--target", text);
          },
          "x,y in mm, table frame; of a robot in space x,y,z, and where the session measured "
          "turns of the tool x,y,z,rx,ry,rz in mm and deg, as rig.toml's orientation reads "
          "them, of the frame that the instrument measured")
      ->type_name("X,Y[,Z[,RX,RY,RZ]]");
}

CLI::Option* add_approach(
    CLI::App& command, const std::shared_ptr<CompensateOptions>& options) {
  return command
      .add_option_function<std::string>(
          "--approach",
          [options](const std::string& text) {
            options->approach.clear();
            for (const double side : figures_of("--approach", text)) {
              if (side != 0.0 && std::abs(side) != 1.0) {
                throw CLI::ValidationError(
                    "--approach", text + " has other figures than 1, -1, 0");
              }
              options->approach.push_back(static_cast<int>(side));
            }
          },
          "of extended: the side that each joint arrives from, as 1,-1; 0: unknown")
      ->type_name("SIDE,SIDE,...");
}

}  // namespace

void add_compensate_command(CLI::App& app, Cli& cli) {
  CLI::App* command = app.add_subcommand(
      "compensate",
      "The joint angles to command so that the calibrated robot reaches a target, or all "
      "targets of a plan.");
  const auto options = std::make_shared<CompensateOptions>();
  add_subject(*command, options->subject);
  CLI::Option* target = add_target(*command, options);
  CLI::Option* plan = command->add_option("--plan", options->plan_file, "a plan file instead")
                          ->check(existing_file())
                          ->excludes(target);
  command->add_option("-o,--output", options->output, "the plan to write; default: stdout")
      ->needs(plan);
  command
      ->add_option(
          "--method,--model", options->by,
          "what commands the robot; extended: robot and named causes of a diagnosis; "
          "extended_full: with what a residual model learned of the rest; recommended: what "
          "`sixdial recommend` says")
      ->check(compensation_words(true))
      ->capture_default_str();
  command->add_option("--mode", options->mode, "working mode; default: the rig's")
      ->check(working_mode_words())
      ->excludes(plan);
  add_stored_result(*command, options->result);
  add_from_other_session(*command, options->from_other_session);
  command->add_option(
      "--calibration", options->result_file,
      "of a bundle: result file of `calibrate -o` instead of calibrating now");
  command
      ->add_option(
          "--calibration-method", options->calibration_method,
          "of a bundle that is calibrated now, such as lm+gp")
      ->capture_default_str();
  command->add_option(
      "--diagnosis", options->diagnosis,
      "of extended: a stored diagnosis by number; default: the newest");
  command
      ->add_option(
          "--diagnosis-file", options->diagnosis_file,
          "of a bundle and extended: result file of `diagnose -o` instead of diagnosing now")
      ->check(existing_file());
  add_approach(*command, options)->excludes(plan);
  command->add_option(
      "--temperature", options->temperature_c,
      "of extended, in degC; default: as at the end of the session");
  add_seed(*command, options->seed, "of a bundle's calibration");
  add_skip_bad_rows(*command, options->skip_bad_rows);
  command->callback([&cli, options] {
    if (options->target.empty() && options->plan_file.empty()) {
      throw CLI::RequiredError("--target or --plan");
    }
    cli.action = [&cli, options] {
      return is_bundle(options->subject) ? compensate_bundle(cli, *options)
                                         : compensate_session(cli, *options);
    };
  });
}

}  // namespace sixdial::cli
