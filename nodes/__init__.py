"""The processes of Scene-Q: one thin file each, round a pure object of ``sceneq_core``."""

NODES: dict[str, str] = {
    "ingest": "sceneq_nodes.ingest:Ingest",
    "segmentation": "sceneq_nodes.segmentation:Segmentation",
    "mapping": "sceneq_nodes.mapping:Mapping",
    "views": "sceneq_nodes.views:Views",
    "encoding": "sceneq_nodes.encoding:Encoding",
    "routing": "sceneq_nodes.routing:Routing",
    "reasoning": "sceneq_nodes.reasoning:Reasoning",
    "mirror": "sceneq_nodes.mirror:Mirror",
    "recorder": "sceneq_nodes.recording.recorder:Recorder",
    "viewer": "sceneq_nodes.viewer:Viewer",
    "gateway": "sceneq_nodes.gateway:Gateway",
    "ros": "sceneq_nodes.ros.output:RosOutput",
}
"""Node kind -> ``module:Class``; third parties add theirs by the entry-point group
``sceneq.nodes``."""
