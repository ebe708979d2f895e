# SPDX-License-Identifier: GPL-3.0-or-later
"""The joint of a drive as a Functional Mock-up Unit (FMI 2.0, co-simulation): twist in, torque and slope out."""
from __future__ import annotations

import hashlib
import io
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from html import escape
from pathlib import Path

from .._engine import InputError
from ..files import writing
from .formats import head_of
from .law import JointLaw

__all__: list[str] = []
NAME = "HarmonicDriveSpring"
ROOM = 2**20   # more than the library and what the compiler keeps [bytes]
_MODEL = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="{guid}" generationTool="hdengine" description="{head}">
  <CoSimulation modelIdentifier="{name}" canHandleVariableCommunicationStepSize="true">
    <SourceFiles><File name="{name}.c"/></SourceFiles>
  </CoSimulation>
  <UnitDefinitions>
    <Unit name="rad"><BaseUnit rad="1"/></Unit>
    <Unit name="N.m"><BaseUnit kg="1" m="2" s="-2"/></Unit>
    <Unit name="N.m/rad"><BaseUnit kg="1" m="2" s="-2" rad="-1"/></Unit>
  </UnitDefinitions>
  <ModelVariables>
    <ScalarVariable name="phi_rel" valueReference="0" causality="input" variability="continuous"
      description="twist of the output against the input"><Real unit="rad" start="0"/></ScalarVariable>
    <ScalarVariable name="tau" valueReference="1" causality="output" variability="continuous"
      description="torque of the spring"><Real unit="N.m"/></ScalarVariable>
    <ScalarVariable name="c" valueReference="2" causality="output" variability="continuous"
      description="slope of the torque"><Real unit="N.m/rad"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="2" dependencies="1"/><Unknown index="3" dependencies="1"/></Outputs>
    <InitialUnknowns><Unknown index="2" dependencies="1"/><Unknown index="3" dependencies="1"/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""
# A line through the table, straight on beyond its ends. Status 0 is OK, 3 an error, as is what co-simulation may leave out.
_SOURCE = """/* {head} */
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#define N {count}
typedef void *component;
typedef unsigned int reference;
static const double angle[N] = {{{angle}}};
static const double torque[N] = {{{torque}}};

static double spring(double phi, double *slope)
{{
  int i = 0;
  while (i < N - 2 && phi > angle[i + 1]) i++;
  *slope = (torque[i + 1] - torque[i]) / (angle[i + 1] - angle[i]);
  return torque[i] + *slope * (phi - angle[i]);
}}

const char *fmi2GetTypesPlatform(void) {{ return "default"; }}
const char *fmi2GetVersion(void) {{ return "2.0"; }}
component fmi2Instantiate(const char *name, int type, const char *guid, const char *place, const void *calls, int visible, int logs)
{{
  (void)name, (void)place, (void)calls, (void)visible, (void)logs;
  return type == 1 && guid && strcmp(guid, "{guid}") == 0 ? calloc(1, sizeof(double)) : NULL;
}}
void fmi2FreeInstance(component c) {{ free(c); }}
int fmi2SetupExperiment(component c, int asks, double tolerance, double from, int ends, double to)
{{
  (void)asks, (void)tolerance, (void)from, (void)ends, (void)to;
  return c ? 0 : 3;
}}
int fmi2EnterInitializationMode(component c) {{ return c ? 0 : 3; }}
int fmi2ExitInitializationMode(component c) {{ return c ? 0 : 3; }}
int fmi2Terminate(component c) {{ return c ? 0 : 3; }}
int fmi2Reset(component c) {{ return c ? *(double *)c = 0, 0 : 3; }}
int fmi2DoStep(component c, double at, double step, int kept) {{ (void)at, (void)step, (void)kept; return c ? 0 : 3; }}
int fmi2SetReal(component c, const reference *r, size_t n, const double *x)
{{
  for (size_t i = 0; i < n; i++)
    if (r[i]) return 3;
    else *(double *)c = x[i];
  return 0;
}}
int fmi2GetReal(component c, const reference *r, size_t n, double *x)
{{
  double slope, phi = *(double *)c, tau = spring(phi, &slope);
  for (size_t i = 0; i < n; i++)
    if (r[i] > 2) return 3;
    else x[i] = r[i] == 0 ? phi : r[i] == 1 ? tau : slope;
  return 0;
}}
int fmi2SetDebugLogging(component c, int on, size_t n, const char *const *names)
{{
  (void)c, (void)on, (void)n, (void)names;
  return 0;
}}
#define NONE(f) int f(component c) {{ (void)c; return 3; }}
NONE(fmi2GetInteger) NONE(fmi2GetBoolean) NONE(fmi2GetString) NONE(fmi2SetInteger) NONE(fmi2SetBoolean) NONE(fmi2SetString)
NONE(fmi2GetFMUstate) NONE(fmi2SetFMUstate) NONE(fmi2FreeFMUstate) NONE(fmi2SerializedFMUstateSize) NONE(fmi2SerializeFMUstate)
NONE(fmi2DeSerializeFMUstate) NONE(fmi2GetDirectionalDerivative) NONE(fmi2SetRealInputDerivatives)
NONE(fmi2GetRealOutputDerivatives) NONE(fmi2CancelStep) NONE(fmi2GetStatus) NONE(fmi2GetRealStatus) NONE(fmi2GetIntegerStatus)
NONE(fmi2GetBooleanStatus) NONE(fmi2GetStringStatus)
"""


def _library(source):
    """The source as a shared library of this machine, by its C compiler."""
    compiler = os.environ.get("CC") or next(filter(shutil.which, ("cc", "gcc", "clang")), None)
    if not compiler:
        raise InputError("--to fmu needs a C compiler: none of cc, gcc, clang is found; name one by CC")
    with tempfile.TemporaryDirectory() as folder:
        with writing(f"{folder}/spring.c"):
            Path(folder, "spring.c").write_text(source)
        command = [*compiler.split(), "-O2", "-shared", "-fPIC", "-o", "spring.so", "spring.c"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, env=os.environ | {"TMPDIR": folder})
        if done.returncode:
            with writing(f"{folder}/spring.so"):   # compilers say in many ways that they find no room
                Path(folder, "room").write_bytes(bytes(ROOM))
            raise InputError(f"{compiler} cannot compile the FMU: {done.stderr.strip()[-300:]}")
        return (Path(folder) / "spring.so").read_bytes()


def to_fmu(law: JointLaw) -> bytes:
    """The archive: model description, C source, and its library for this machine. Without a C compiler an InputError."""
    head = "; ".join(head_of(law))
    angle, torque = (", ".join(f"{v:.17g}" for v in values) for values in (law.angle_rad, law.torque_nm))
    guid = hashlib.sha256(f"{angle};{torque}".encode()).hexdigest()[:32]
    source = _SOURCE.format(head=head.replace("*/", "* /"), count=len(law.angle_rad), angle=angle, torque=torque, guid=guid)
    place = {"linux": "linux64", "darwin": "darwin64"}.get(sys.platform, sys.platform)
    suffix = "dylib" if sys.platform == "darwin" else "so"
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in (("modelDescription.xml", _MODEL.format(name=NAME, guid=guid, head=escape(head, quote=True))),
                              (f"sources/{NAME}.c", source), (f"binaries/{place}/{NAME}.{suffix}", _library(source))):
            archive.writestr(zipfile.ZipInfo(name), content)   # of 1980: the same law gives the same bytes
    return buffer.getvalue()
