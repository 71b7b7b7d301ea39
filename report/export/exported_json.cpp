#include "report/export/exported_json.h"

#include "report/documents/fields.h"

namespace sixdial::report {

template <class Fields>
void describe_keys(Fields& at, Of<Fields, studies::MissBetween>& miss) {
  at("mean_mm", miss.mean_mm);
  at("max_mm", miss.max_mm);
  at("poses", miss.poses);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, LeftOut>& left) {
  at("what", left.what);
  at("why", left.why);
  at("instead", left.instead);
  at("values", left.values);
  at("miss", left.miss);
}

template <class Fields>
void describe_keys(Fields& at, Of<Fields, Exported>& exported) {
  at("format", exported.format);
  at("file_name", exported.file_name);
  at("model", exported.model);
  at("left_out", exported.left_out);
  at("notes", exported.notes);
  at("miss", exported.miss);
}

Json to_json(const Exported& exported) { return write(exported); }

Exported exported_from_json(const Json& json) { return read<Exported>(json, "sixdial.export"); }

}  // namespace sixdial::report
