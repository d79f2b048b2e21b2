"""Which implementations stand behind each seam, and how one is built from ``{kind: ..., ...}``.

Every backend class has a frozen ``Params`` dataclass as class attribute and takes one instance of
it. Third parties add kinds by the entry-point group ``sceneq.<seam>``.
"""

import importlib
from collections.abc import Mapping
from typing import Any

from sceneq_nodes import NODES
from sceneq_nodes._params import ParamError, did_you_mean, validate

BACKENDS: dict[str, dict[str, str]] = {
    "nodes": NODES,
    "source": {
        "folder": "sceneq_nodes._folder_source:FolderSource",
        "scannet": "sceneq_nodes._scannet_source:ScannetSource",
        "replica": "sceneq_nodes._replica_source:ReplicaSource",
        "tum": "sceneq_nodes._tum_source:TumSource",
        "ros2": "sceneq_nodes.ros.source:Ros2Source",
        "kitti": "sceneq_nodes.lidar.kitti_source:KittiSource",
        "redwood": "sceneq_nodes.datasets.redwood_source:RedwoodSource",
        "r3d": "sceneq_nodes.datasets.record3d_source:Record3dSource",
        "realsense": "sceneq_nodes.cameras.realsense_source:RealsenseSource",
        "oak": "sceneq_nodes.cameras.oak_source:OakSource",
        "orbbec": "sceneq_nodes.cameras.orbbec_source:OrbbecSource",
        "record3d": "sceneq_nodes.cameras.record3d_source:Record3dUsbSource",
        "azure": "sceneq_nodes.datasets.azure_source:AzureSource",
        "mcap": "sceneq_nodes.recording.mcap_source:McapSource",
        "rosbag": "sceneq_nodes.recording.bag_source:BagSource",
        "rtabmap": "sceneq_nodes.datasets.rtabmap_source:RtabmapSource",
    },
    "odometry": {
        "depth_icp": "sceneq_core.ingest.depth_odometry:DepthOdometry",
        "kiss_icp": "sceneq_core.ingest.odometry:KissIcpOdometry",
    },
    "keyframes": {
        "interval": "sceneq_core.ingest.keyframes:Interval",
        "every": "sceneq_core.ingest.keyframes:EveryNth",
        "motion": "sceneq_core.ingest.keyframes:Motion",
    },
    "segmenter": {
        "rgbd": "sceneq_core.segmentation.rgbd:RgbdSegmenter",
        "files": "sceneq_nodes._files_segmenter:FilesSegmenter",
        "sam": "sceneq_nodes._sam_segmenter:SamSegmenter",
        "onnx": "sceneq_nodes._onnx_segmenter:OnnxSegmenter",
    },
    "proposals": {
        "none": "sceneq_core.mapping.proposals:NoProposals",
        "file": "sceneq_nodes._proposal_file:ProposalFile",
    },
    "encoder": {
        "conse": "sceneq_nodes._conse_encoder:ConseEncoder",
        "openclip": "sceneq_nodes._openclip_encoder:OpenclipEncoder",
        "transformers": "sceneq_nodes._transformers_encoder:TransformersEncoder",
        "onnx": "sceneq_nodes._onnx_encoder:OnnxEncoder",
        "hash": "sceneq_core.encoding.hash:HashEncoder",
    },
    "reasoner": {
        "geometric": "sceneq_core.reasoning.geometric:GeometricReasoner",
        "openai": "sceneq_nodes._openai_reasoner:OpenAiReasoner",
        "transformers": "sceneq_nodes._transformers_reasoner:TransformersReasoner",
    },
}


def build(seam: str, spec: Mapping[str, Any], path: tuple[str | int, ...] = ()) -> Any:
    """Return the backend that ``spec`` names, its other keys validated as its parameters.

    Raises:
        ParamError: no or unknown ``kind``, or a bad parameter.
    """
    cls, params = check(seam, spec, path)
    return cls(params)


def check(
    seam: str, spec: Mapping[str, Any], path: tuple[str | int, ...] = ()
) -> tuple[type[Any], Any]:
    """Return the class and validated parameters of ``spec`` without building anything."""
    if not isinstance(spec, Mapping) or "kind" not in spec:
        raise ParamError((*path, "kind"), spec, "missing key", "add 'kind: ...'")
    cls = load(seam, str(spec["kind"]), path)
    return cls, validate(cls.Params, {k: v for k, v in spec.items() if k != "kind"}, path)


def load(seam: str, kind: str, path: tuple[str | int, ...] = ()) -> type[Any]:
    """Return the class behind ``kind``; ours first, then entry points.

    Raises:
        ParamError: no such kind, or its module cannot be imported.
    """
    target = BACKENDS[seam].get(kind) or kinds(seam).get(kind)
    if target is None:
        raise ParamError((*path, "kind"), kind, "unknown kind", did_you_mean(kind, kinds(seam)))
    module, _, name = target.partition(":")
    try:
        cls: type[Any] = getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError) as error:
        raise ParamError((*path, "kind"), kind, f"cannot load {target}: {error}", "") from error
    return cls


def kinds(seam: str) -> dict[str, str]:
    """Return every known kind of a seam with its ``module:Class``; scans what is installed."""
    from importlib.metadata import entry_points

    plugins = {point.name: point.value for point in entry_points(group=f"sceneq.{seam}")}
    return plugins | BACKENDS[seam]
